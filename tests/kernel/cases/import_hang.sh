# init: systemd
# memory: 2G
# limit: 600
# The installed daemon under systemd, with a reader that never answers and ignores every signal it can: `systemctl stop` ends both,
# whether the file hangs beside a picture or is the first one, and systemd does not have to kill anything. The log tells how long each
# stop took; an emulated guest on a busy machine is many times as slow as what it stands for, so no time is asserted.
. "$QUILTD_SOURCE/tests/kernel/lib.sh"

settings() { # scene
    printf '%s\n' "QUILTD_SCENE=$1" \
        'QUILTD_OPTIONS="--views 2 --view-size 45x60 --device none --allow-path /srv/scenes"' > /etc/default/quiltd
}
hanging_reader() {
    mkdir -p /srv/readers /srv/scenes /etc/systemd/system/quiltd.service.d
    printf '%s\n' '#!/bin/sh' "trap '' TERM INT HUP" 'exec sleep 100017' > /srv/readers/quiltimport
    chmod 755 /srv/readers/quiltimport
    # less than the time that a file may take: a daemon that waited for its reader would be killed
    printf '%s\n' '[Service]' 'Environment=QUILTIMPORT=/srv/readers' TimeoutStopSec=60 > /etc/systemd/system/quiltd.service.d/readers.conf
    echo ply > /srv/scenes/m.ply
    printf '%s\n' '{"quiltd": 1, "camera": {"position": [0, 0, 5], "target": [0, 0, 0], "fov_y": 30},' \
        '"meshes": {"m": {"file": "m.ply"}}, "lights": {"l": {"type": "point", "position": [3, 3, 3], "intensity": 9}}}' \
        > /srv/scenes/hang.json
    systemctl daemon-reload
}
tell() {
    quiltctl status
    journalctl --no-pager -n 20 -u quiltd
}
reading() { quiltctl status --all > status.log && grep -q '^reading.file *.*m.ply' status.log; }
hangs() { { within 60 reading && pgrep -f 'sleep 100017' > reader.pid; } || tell; }
still_shows() { timeout 120 quiltctl wait for=complete generation=1 > /dev/null || tell; }
stops() { # by itself
    local from=$EPOCHREALTIME
    systemctl stop quiltd 2> stop.log || tell # which warns of the socket
    echo "# stopped in $(awk -v a="$from" -v b="$EPOCHREALTIME" 'BEGIN { printf "%.2f", b - a }') s" >&4
    [ "$(systemctl show quiltd -P Result)" = success ] || systemctl show quiltd -p Result,ExecMainStatus
}
readers_gone() { ! pgrep -f 'sleep 100017' || echo "a reader is still there"; }

exec 4>&1 # the log
systemd-sysusers
systemd-tmpfiles --create /usr/lib/tmpfiles.d/quiltd.conf
hanging_reader
settings /usr/share/quiltd/scenes/spheres.json

fact "the service becomes active" succeeds systemctl start quiltd
fact "it shows a picture" still_shows
fact "it stops" stops
fact "it becomes active again" succeeds systemctl start quiltd
quiltctl scene.load file=/srv/scenes/hang.json > load.log 2>&1 &
fact "a file hangs in its reader" hangs
fact "the picture goes on beside it" still_shows
fact "doctor tells the limits" succeeds sh -c 'quiltctl doctor > doctor.log; grep -q "^ok    service: MemoryMax=[0-9]" doctor.log || { cat doctor.log; false; }'
fact "which fit" succeeds sh -c '! grep "^note  service" doctor.log'
fact "the service stops without it" stops
fact "no reader is left" readers_gone
wait
settings /srv/scenes/hang.json
systemctl start --no-block quiltd
fact "the first file hangs in its reader" hangs
fact "the service stops without it again" stops
fact "and leaves no reader again" readers_gone
finish
