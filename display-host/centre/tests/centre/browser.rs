//! Chromium without a window, controlled over its debugging port.

use std::io::{BufRead as _, BufReader};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Stdio};

use base64::Engine as _;
use serde_json::{Value, json};
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

use crate::support::{Killed, wait};

/// A browser with one page.
pub(crate) struct Browser {
    _process: Killed,
    line: WebSocket<MaybeTlsStream<TcpStream>>,
    number: u64,
}

impl Browser {
    /// Starts a browser. `None`, with the reason printed: there is none.
    pub(crate) fn start(folder: &Path) -> Option<Self> {
        let mut command = Command::new("chromium");
        command.args([
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--ignore-certificate-errors",
            "--remote-debugging-port=0",
            "--window-size=1400,900",
            "--lang=en",
        ]);
        command
            .arg(format!("--user-data-dir={}", folder.display()))
            .arg("about:blank");
        let Ok(mut child) = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn() else {
            println!("skipped: there is no chromium (Debian: apt install chromium)");
            return None;
        };
        let lines = BufReader::new(child.stderr.take().expect("its messages")).lines();
        let mut lines = lines.map_while(Result::ok);
        let process = Killed(child);
        let address =
            lines.find_map(|it| Some(it.split_once("DevTools listening on ")?.1.to_owned()));
        let Some(address) = address else {
            println!("skipped: chromium does not start here");
            return None;
        };
        // The pipe has to be emptied.
        std::thread::spawn(move || lines.count());
        let mut browser = Self {
            _process: process,
            line: line(&address),
            number: 0,
        };
        let page = browser.call("Target.createTarget", &json!({"url": "about:blank"}));
        let page = page["targetId"].as_str().expect("a page").to_owned();
        let (host, _) = address.split_once("/devtools/").expect("an address");
        browser.line = line(&format!("{host}/devtools/page/{page}"));
        Some(browser)
    }

    fn call(&mut self, method: &str, values: &Value) -> Value {
        self.number += 1;
        let text = json!({"id": self.number, "method": method, "params": values}).to_string();
        self.line.send(Message::text(text)).expect("sent");
        loop {
            if let Message::Text(text) = self.line.read().expect("chromium answers") {
                let told: Value = serde_json::from_str(&text).expect("JSON");
                if told["id"] == self.number {
                    assert!(told["error"].is_null(), "{method}: {told}");
                    return told["result"].clone();
                }
            }
        }
    }

    pub(crate) fn open(&mut self, address: &str) {
        self.call("Page.navigate", &json!({"url": address}));
    }

    /// Value of an expression on the page.
    pub(crate) fn value(&mut self, expression: &str) -> Value {
        let asked = json!({"expression": expression, "awaitPromise": true, "returnByValue": true});
        let told = self.call("Runtime.evaluate", &asked);
        assert!(told["exceptionDetails"].is_null(), "{expression}: {told}");
        told["result"]["value"].clone()
    }

    /// Waits until an expression is true. It may fail while the page is being loaded.
    pub(crate) fn until(&mut self, expression: &str) {
        let safe = format!(
            "(() => {{ try {{ return Boolean({expression}) }} catch {{ return false }} }})()"
        );
        wait(expression, || (self.value(&safe) == true).then_some(()));
    }

    /// Gives the page the size of another screen.
    pub(crate) fn resize(&mut self, width: u32, height: u32) {
        let size =
            json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": false});
        self.call("Emulation.setDeviceMetricsOverride", &size);
    }

    pub(crate) fn picture(&mut self, file: &Path) {
        let told = self.call("Page.captureScreenshot", &json!({"format": "png"}));
        let data = told["data"].as_str().expect("a picture");
        let png = base64::engine::general_purpose::STANDARD
            .decode(data)
            .expect("base64");
        std::fs::write(file, png).expect("written");
    }
}

fn line(address: &str) -> WebSocket<MaybeTlsStream<TcpStream>> {
    tungstenite::connect(address).expect("a line").0
}
