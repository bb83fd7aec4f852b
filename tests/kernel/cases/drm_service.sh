# init: systemd
# memory: 2G
# limit: 900
# qemu: -device virtio-gpu-pci,xres=1536,yres=2048,max_hostmem=256M
# The installed daemon under systemd, out of its sandbox and as its own user, shows on a display output, and gives the console back.
. "$QUILTD_SOURCE/tests/kernel/lib.sh"

settings() {
    printf '%s\n' 'QUILTD_SCENE=/usr/share/quiltd/scenes/spheres.json' \
        'QUILTD_OPTIONS="--views 2 --view-size 45x60 --target-error 0.1 --device drm:Virtual-1 --calibration /etc/quiltd-visual.json"' \
        > /etc/default/quiltd
    printf '%s' '{"configVersion":"3.0","serial":"LKG-PORT-02283","pitch":{"value":52.563},"slope":{"value":-7.2447},"center":{"value":0.4017},' \
        '"viewCone":{"value":40},"DPI":{"value":324},"screenW":{"value":1536},"screenH":{"value":2048},"invView":{"value":1}}' \
        > /etc/quiltd-visual.json
}
on_display() { quiltctl status --all > status.log && grep -q 'drm:card0/Virtual-1' status.log; }
shows() { on_display || { cat status.log; journalctl --no-pager -n 20 -u quiltd; }; }
same_picture() {
    screendump service
    "$QUILTD_BUILD/tests/kernel/same_picture" /var/lib/quiltd/export/panel.png "$RESULTS/service.ppm" > same.log
}
differs() { ! "$QUILTD_BUILD/tests/kernel/same_picture" /var/lib/quiltd/export/panel.png "$RESULTS/console.ppm" > same.log || cat same.log; }
pictured() { within 60 same_picture || cat same.log; }
present() { quiltctl status --all > status.log && grep -q "present *$1" status.log; } # true or false
unplugged() {
    echo off > /sys/class/drm/card0-Virtual-1/status
    echo change > /sys/class/drm/card0/uevent
    within 60 present false || shows
}
replugged() {
    echo detect > /sys/class/drm/card0-Virtual-1/status
    within 60 present true || shows
}
killed() { systemctl kill --signal=KILL quiltd && within 60 console killed; }
console() { screendump "$1" && cmp -s "$RESULTS/$1.ppm" "$RESULTS/console.ppm"; }

modprobe virtio-gpu
within 60 test -e /dev/dri/card0
systemctl stop getty@tty1 2> /dev/null
systemd-sysusers
systemd-tmpfiles --create /usr/lib/tmpfiles.d/quiltd.conf
udevadm trigger && udevadm settle
settings
printf '\033[2J\033[H\033[?25lthis is the console\n' > /dev/tty1
sleep 1
screendump console

fact "the service becomes active" succeeds systemctl start quiltd
fact "it has the display" shows
fact "a complete picture is there" succeeds timeout 200 quiltctl wait for=converged
fact "the panel's picture is written" succeeds quiltctl export panel /var/lib/quiltd/export/panel.png denoise=on
fact "the display shows it pixel for pixel" pictured
fact "which is not the console" differs
fact "taking the monitor away is told" unplugged
fact "and its return" replugged
fact "the display shows the picture again" pictured
fact "the service stops" succeeds systemctl stop quiltd
fact "the console comes back" succeeds within 60 console after
fact "the service starts again" succeeds systemctl start quiltd
fact "it has the display again" shows
sed -i 's/^QUILTD_OPTIONS=.*/QUILTD_OPTIONS="--device none"/' /etc/default/quiltd
fact "killed, it gives the console back" succeeds killed
rm -f "$RESULTS"/*.ppm
finish
