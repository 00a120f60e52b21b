#!/bin/sh
# Keys for a link, with openssl 3: an authority of your own, and a certificate for each station and each watcher.
#   sh make_keys.sh authority                        once: ca.pem for everybody, ca.key for nobody
#   sh make_keys.sh station NAME IP:10.0.0.7         for a station: the addresses that watchers connect to,
#                                                    IP:… or DNS:…, with commas between several
#   sh make_keys.sh watcher NAME                     for an instructor's computer
#   sh make_keys.sh centre NAME IP:10.0.0.2          for `calot centre`: its addresses, as above
#   sh make_keys.sh member NAME                      for a station that joins a centre
# Give each computer its NAME.pem, its NAME.key and ca.pem; keep ca.key where none of them is.
set -eu
umask 077
new="openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -batch"
signed="-CA ca.pem -CAkey ca.key -days 825 -addext basicConstraints=critical,CA:FALSE"
# Words that no key would hold are refused: a second address belongs behind a comma.
case "${1-} $#" in
"authority 1" | "station 3" | "watcher 2" | "centre 3" | "member 2") ;;
*) set -- help ;;
esac
case "$1" in
authority)
    $new -days 3650 -keyout ca.key -out ca.pem -subj "/CN=Calot authority" \
        -addext keyUsage=critical,keyCertSign
    ;;
station | centre)
    # shellcheck disable=SC2086
    $new $signed -keyout "$2.key" -out "$2.pem" -subj "/CN=$2" \
        -addext extendedKeyUsage=serverAuth -addext "subjectAltName=$3"
    ;;
watcher | member)
    # shellcheck disable=SC2086
    $new $signed -keyout "$2.key" -out "$2.pem" -subj "/CN=$2" \
        -addext extendedKeyUsage=clientAuth -addext "subjectAltName=DNS:$2"
    ;;
*)
    sed -n '2,9s/^# \{0,1\}//p' "$0"
    exit 2
    ;;
esac
