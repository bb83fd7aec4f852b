# The guest comes up at all: what finding an accelerator runs.
. "$QUILTD_SOURCE/tests/kernel/lib.sh"
fact "the guest's kernel has its modules" succeeds modprobe --dry-run vhci_hcd
finish
