# The drm device at the greatest size there is, 7680x4320.
# limit: 600
# memory: 2G
# qemu: -device virtio-gpu-pci,xres=7680,yres=4320,max_hostmem=1G
. "$QUILTD_SOURCE/tests/kernel/lib.sh"
. "$QUILTD_SOURCE/tests/kernel/show.sh"

modprobe virtio-gpu
within 60 test -e /dev/dri/card0
show_start drm:Virtual-1 7680x4320 20
fact "frames and rectangles of 7680x4320 are taken" shown
fact "the display shows the frame pixel for pixel" pictured picture
show_end
fact "the program ends" ended_well
cat show.log
rm -f "$RESULTS"/*.ppm
finish
