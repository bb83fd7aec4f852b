# init: systemd
# memory: 2G
# limit: 600
# The installed daemon under systemd, with a reader that never answers and ignores every signal it can: `systemctl stop` ends both
# within 2 s, whether the file hangs beside a picture or is the first one.
. "$QUILTD_SOURCE/tests/kernel/lib.sh"

settings() { # scene
    printf '%s\n' "QUILTD_SCENE=$1" \
        'QUILTD_OPTIONS="--views 2 --view-size 45x60 --device none --allow-path /srv/scenes"' > /etc/default/quiltd
}
hanging_reader() {
    mkdir -p /srv/readers /srv/scenes /etc/systemd/system/quiltd.service.d
    printf '%s\n' '#!/bin/sh' "trap '' TERM INT HUP" 'exec sleep 100017' > /srv/readers/quiltimport
    chmod 755 /srv/readers/quiltimport
    printf '%s\n' '[Service]' 'Environment=QUILTIMPORT=/srv/readers' > /etc/systemd/system/quiltd.service.d/readers.conf
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
reading() { quiltctl status > status.log && grep -q '^reading.file *.*m.ply' status.log; }
hangs() { { within 60 reading && pgrep -f 'sleep 100017' > reader.pid; } || tell; }
still_shows() { timeout 120 quiltctl wait for=complete generation=1 > /dev/null || tell; }
stops() { # seconds that it may take; $took is how long it took
    local from=$EPOCHREALTIME
    systemctl stop quiltd 2> stop.log || tell # which warns of the socket
    took=$(awk -v a="$from" -v b="$EPOCHREALTIME" 'BEGIN { printf "%.2f", b - a }')
    awk -v took="$took" -v most="$1" 'BEGIN { if (took > most) print "stopping took " took " s, expected at most " most " s" }'
}
ended_well() { [ "$(systemctl show quiltd -p Result --value)" = success ] || systemctl show quiltd -p Result,ExecMainStatus; }
readers_gone() { ! pgrep -f 'sleep 100017' || echo "a reader is still there"; }

systemd-sysusers
systemd-tmpfiles --create /usr/lib/tmpfiles.d/quiltd.conf
hanging_reader
settings /usr/share/quiltd/scenes/spheres.json

# an emulated machine is slow: two seconds more than where nothing hangs
fact "the service becomes active" succeeds systemctl start quiltd
fact "it shows a picture" still_shows
fact "it stops" stops 7
most=$(awk -v took="$took" 'BEGIN { print took + 2 }')
echo "# stopped in $took s"
fact "it becomes active again" succeeds systemctl start quiltd
quiltctl scene.load file=/srv/scenes/hang.json > load.log 2>&1 &
fact "a file hangs in its reader" hangs
fact "the picture goes on beside it" still_shows
fact "doctor tells the limits" succeeds sh -c 'quiltctl doctor > doctor.log; grep -q "^ok    service: MemoryMax=[0-9]" doctor.log || { cat doctor.log; false; }'
fact "which fit" succeeds sh -c '! grep "^note  service" doctor.log'
fact "the service stops within 2 s" stops "$most"
echo "# stopped in $took s"
fact "its end is no failure" ended_well
fact "nor is a reader left" readers_gone
wait
settings /srv/scenes/hang.json
systemctl start --no-block quiltd
fact "the first file hangs in its reader" hangs
fact "the service stops within 2 s again" stops "$most"
echo "# stopped in $took s"
fact "and leaves no reader again" readers_gone
finish
