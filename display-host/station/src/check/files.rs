//! Files that give an ordinary user realtime rights: limits, udev rules, a systemd unit.

use std::path::Path;

/// Shell script that installs the files. The program only prints it, so that the user can read it
/// before root runs it.
pub(crate) fn script(program: &Path, core: usize) -> String {
    let program = program.display();
    format!(
        r#"#!/bin/sh
# Lets members of the group `realtime` run calot in realtime. Read it, then: calot check --install | sudo sh
set -eu
groupadd -f realtime
if [ -n "${{SUDO_USER:-}}" ]; then usermod -a -G realtime,dialout "$SUDO_USER"; fi

cat > /etc/security/limits.d/95-calot.conf <<'LIMITS'
# SCHED_FIFO up to 95 and locked memory, from the next login on.
@realtime - rtprio 95
@realtime - memlock unlimited
LIMITS

cat > /etc/udev/rules.d/95-calot.rules <<'RULES'
# Lets calot forbid deep idle states while it runs.
KERNEL=="cpu_dma_latency", GROUP="realtime", MODE="0660"
# By default FTDI chips hold bytes back for 16 ms.
ACTION=="add", SUBSYSTEM=="usb-serial", DRIVER=="ftdi_sio", ATTR{{latency_timer}}="1"
# Force Dimension's devices and Novint's Falcon, which the vendor's library opens on the USB.
SUBSYSTEM=="usb", ATTR{{idVendor}}=="1451", GROUP="dialout", MODE="0660"
SUBSYSTEM=="usb", ATTR{{idVendor}}=="0403", ATTR{{idProduct}}=="cb48", GROUP="dialout", MODE="0660"
RULES
cat > /etc/systemd/system/calot@.service <<UNIT
# systemctl start calot@SCENE runs the controller of /var/lib/calot/SCENE.calot by itself.
# Shared memory belongs to its user, so run the display as that user.
[Unit]
Description=Calot realtime controller, scene %i
After=multi-user.target

[Service]
ExecStart={program} rt --scene /var/lib/calot/%i.calot --core {core} --strict
User=${{SUDO_USER:-root}}
SupplementaryGroups=realtime dialout
LimitRTPRIO=95
LimitMEMLOCK=infinity
Restart=on-failure
RestartSec=1

[Install]
WantedBy=multi-user.target
UNIT

# Without udev and systemd (a container, another init) the files apply later.
if udevadm control --reload; then
  udevadm trigger --subsystem-match=usb-serial --subsystem-match=misc --action=add
else
  echo "udev did not answer: its rules apply after the next boot"
fi
systemctl daemon-reload || echo "systemd did not answer: start the controller by hand"
echo "installed; log out and in again, then: calot check"
"#
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_script_is_a_shell_script_with_limits_rules_and_a_unit() {
        let script = script(Path::new("/usr/local/bin/calot"), 3);
        for part in [
            "@realtime - rtprio 95",
            "@realtime - memlock unlimited",
            "ATTR{latency_timer}=\"1\"",
            "ATTR{idVendor}==\"1451\"",
            "LimitRTPRIO=95",
            "ExecStart=/usr/local/bin/calot rt --scene /var/lib/calot/%i.calot --core 3 --strict",
        ] {
            assert!(script.contains(part), "{part}");
        }
        let checked = std::process::Command::new("sh")
            .args(["-n", "-c", &script])
            .status();
        assert!(checked.unwrap().success(), "sh does not parse it");
    }
}
