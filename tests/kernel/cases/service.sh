# init: systemd
# memory: 2G
# limit: 900
# The installed daemon under systemd, as its units, users and rules are shipped: it becomes active whatever is missing, comes back
# after a crash, and reaches its devices out of its sandbox.
. "$QUILTD_SOURCE/tests/kernel/lib.sh"
panel=$QUILTD_BUILD/tests/kernel/panel

# Two threads, so that there is a worker on a single processor; an end to rendering, which would keep that busy all the while.
options() {
    printf '%s\n' 'QUILTD_OPTIONS="--views 4 --view-size 60x80 --threads 2 --target-error 0.1"' "$@" > /etc/default/quiltd
}
small=QUILTD_SCENE=/usr/share/quiltd/scenes/spheres.json
becomes_active() {
    systemctl start quiltd 2>&1
    [ "$(systemctl is-active quiltd)" = active ] || { systemctl status --no-pager quiltd; journalctl --no-pager -n 20 -u quiltd; }
}
stops() {
    systemctl stop --quiet quiltd 2>&1
    [ "$(systemctl is-active quiltd)" = inactive ] || systemctl status --no-pager quiltd
}
main_pid() { systemctl show -P MainPID quiltd; }
another_pid() { [ "$(main_pid)" != "$1" ] && [ "$(main_pid)" != 0 ] && [ "$(systemctl is-active quiltd)" = active ]; }
comes_back() {
    local before
    before=$(main_pid)
    kill -SEGV "$before"
    within 120 another_pid "$before" || systemctl status --no-pager quiltd
}
# A mesh is read by a process of its own, which says whether the kernel's Landlock holds it; Debian's has it.
readers_are_locked() {
    printf '%s\n' ply 'format ascii 1.0' 'element vertex 3' 'property float x' 'property float y' 'property float z' \
        'element face 1' 'property list uchar int vertex_indices' end_header '0 0 0' '1 0 0' '0 1 0' '3 0 1 2' > /usr/share/quiltd/scenes/locked.ply
    timeout 120 quiltctl scene.load file=/usr/share/quiltd/scenes/locked.ply > load.log 2>&1 || cat load.log
    quiltctl status --all > status.log 2>&1
    grep -q '^landlock  *on$' status.log || { grep '^landlock' status.log; cat /sys/kernel/security/lsm; }
    ! journalctl --no-pager -u quiltd | grep 'without Landlock'
}
# ProtectHome=yes
says_home() {
    mkdir -p /home/somebody && echo '{}' > /home/somebody/scene.json
    # of a slideshow the daemon opens the files, not quiltctl
    timeout 60 quiltctl playlist.set entries:='[{"file":"/home/somebody/scene.json"}]' > home.log 2>&1
    grep -q 'cannot see home folders' home.log || cat home.log
}
answers() { timeout 60 quiltctl status > status.log 2>&1 || cat status.log; }
niceness() { sed 's/.*) //' "$1/stat" | cut -d' ' -f17; } # /proc folder
renders_behind() { # the rest of the daemon
    local rest task pid
    pid=$(main_pid)
    rest=$(niceness "/proc/$pid")
    for task in "/proc/$pid"/task/*; do
        [ "$(cat "$task/comm")" = lf-worker ] || continue
        [ "$(niceness "$task")" -gt "$rest" ] || echo "a worker is as nice as the rest, $rest"
        return
    done
    echo "no worker is there"
}
runs_as() { # user
    [ "$(stat -c %U "/proc/$(main_pid)")" = "$1" ] || echo "the daemon runs as $(stat -c %U "/proc/$(main_pid)")"
}
hardened() {
    local level
    level=$(systemd-analyze security quiltd --no-pager | sed -n 's/.*exposure level[^:]*: \([0-9.]*\).*/\1/p')
    echo "  exposure level $level" >&4
    awk -v e="$level" 'BEGIN { exit !(e == "" || e > 2.0) }' && echo "exposure level $level, expected at most 2.0"
}
shows_on() { timeout 60 quiltctl device.list > list.log 2>&1 && grep -q "^present.kind *$1" list.log; } # kind of device
gone() { timeout 60 quiltctl device.list > list.log 2>&1 && grep -q '^present.present *false' list.log; }
found() { # the display by USB, its calibration by HID
    within 60 shows_on usb
    grep '^present' list.log >&4
    grep -q '^present.kind *usb' list.log || cat list.log
    grep -q '^present.calibration_from *.*hidraw' list.log || cat list.log
}
bytes_shown() { sim_tell counters; sed -n 's/^lit=.* bytes=\([0-9]*\).*/\1/p' sim.log | tail -n 1; }
rests() { # no more is sent
    local before
    before=$(bytes_shown)
    sleep 2
    [ "$before" = "$(bytes_shown)" ]
}
shows_frame() {
    timeout 120 quiltctl wait for=complete > wait.log 2>&1 || cat wait.log
    quiltctl render.set paused=true > paused.log 2>&1 || cat paused.log
    within 60 rests || echo "it never rests"
    timeout 60 quiltctl export panel frame.png denoise=on > export.log 2>&1 || cat export.log
    sim_tell picture
    "$panel" same frame.png shown.png
    sim_tell counters
    echo "  $(grep '^lit=' sim.log | tail -n 1)" >&4
}
# After unplugging and replugging, without being told. How long that took stands in the log, by the panel's own clock; an emulated guest
# is many times as slow as what it stands for.
shows_again() {
    local seconds
    quiltctl render.set paused=false > paused.log 2>&1 || cat paused.log
    sim_tell unplug
    sleep 2
    sim_tell replug
    within 120 shows_something || { echo "nothing comes"; quiltctl device.list; }
    seconds=$(sed -n 's/^lit=.* first_ms=\([0-9]*\)$/\1/p' sim.log | tail -n 1)
    echo "  shown again $seconds ms after replugging" >&4
}
shows_nothing() { [ "$(bytes_shown)" -eq 0 ] || grep '^lit=' sim.log; }
shows_something() { [ "$(bytes_shown)" -gt 0 ]; }
ends_in_time() { # by itself, before systemd kills it
    local since=$EPOCHREALTIME
    stops
    echo "  stopped after $(awk -v a="$since" -v b="$EPOCHREALTIME" 'BEGIN { printf "%.1f", b - a }') s" >&4
    [ "$(systemctl show -P Result quiltd)" = success ] || systemctl show -p Result quiltd
}
# The daemon's own unit with another program in it.
in_its_sandbox() { # name, command
    sed -e "s|^ExecStart=.*|ExecStart=$2|" -e 's/^Type=.*/Type=oneshot/' -e '/^ExecReload\|^Restart\|^Watchdog\|^NotifyAccess\|^Requires\|^After\|^Timeout/d' \
        /usr/lib/systemd/system/quiltd.service > "/run/systemd/system/$1.service"
    systemctl daemon-reload
    systemctl start "$1" 2>&1 || journalctl --no-pager -n 20 -u "$1"
}

exec 4>&1
fact "users are made" succeeds systemd-sysusers
fact "folders are made" succeeds systemd-tmpfiles --create /usr/lib/tmpfiles.d/quiltd.conf
fact "the socket is there" succeeds systemctl start quiltd.socket
options
fact "active without a device" becomes_active
fact "as its own user" runs_as quiltd
fact "it answers" answers
fact "it says why it does not see /home" says_home
fact "its readers are held by Landlock" readers_are_locked
fact "rendering goes behind the rest of it" renders_behind
fact "the service is hardened" hardened
fact "active again after a crash" comes_back
fact "and answers" answers
fact "it stops" stops
options QUILTD_SCENE=/nonexistent.json
fact "active with the scene missing" becomes_active
fact "it says so" answers
fact "it stops again" stops
options $small
cp "$panel" /usr/local/bin/panel
printf '%s' '{"configVersion":"3.0","serial":"LKG-PORT-NOMINAL","pitch":52,"slope":-7,"center":0.5,"DPI":324,"screenW":512,"screenH":512}' > /var/lib/quiltd/nominal.json
chown quiltd: /var/lib/quiltd/nominal.json
fact "active once more" becomes_active
fact "it shows nothing" succeeds within 60 shows_on none
fact "vhci_hcd is there" succeeds modprobe vhci_hcd
fact "the first panel is plugged in while it runs" sim_start --attach --calibration /var/lib/quiltd/nominal.json --panel-png shown.png
fact "its nodes belong to the group quiltd" succeeds within 60 granted hid usb
fact "it has found the panel by itself" found
fact "what it shows is the exact frame" shows_frame
fact "after replugging it shows on" shows_again
fact "it stops with a device" ends_in_time
fact "active with a device" becomes_active
fact "it answers with a device" answers
fact "it has found the panel again" found
sim_stop
fact "it notices that the panel is gone" succeeds within 60 gone
fact "a panel is plugged in whose display takes no pixels" sim_start --attach --calibration /var/lib/quiltd/nominal.json --hang-every 1
fact "it is taken" succeeds within 120 shows_on usb
fact "the daemon answers while its display hangs" answers
fact "which has shown nothing" shows_nothing
fact "and stops" ends_in_time
sim_stop
fact "a sound panel is plugged in" sim_start --attach --calibration /var/lib/quiltd/nominal.json --panel-png shown.png
fact "it is there" succeeds within 60 granted hid usb
fact "the EEPROM is read out of the sandbox" in_its_sandbox quilt-eeprom "/usr/local/bin/panel eeprom /var/lib/quiltd/nominal.json"
fact "the display is drawn to out of the sandbox" in_its_sandbox quilt-draw "/usr/local/bin/panel draw 512x512 1 20 /var/lib/quiltd/expected.png"
sim_tell picture
fact "it shows what was drawn" "$panel" same /var/lib/quiltd/expected.png shown.png
sim_stop
finish
