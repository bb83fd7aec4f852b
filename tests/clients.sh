#!/bin/bash
# Programs that people have, before the services of quiltweb that are theirs: bridge.js, a WebXR page, nng's nngcat, and the requests of
# AliceLG, VTK's module and quiltwright (tests/clients). First the negative control: the same steps before a small gateway that is
# right, and then wrong in one way after the other. They need the ports of Bridge.
#   make check-clients
set -u
src=$(cd "${QUILTD_SOURCE:-.}" && pwd)
out=$(cd "${QUILTD_BUILD:-build/release}" && pwd)
# shellcheck source=tests/report.sh
. "$src/tests/report.sh"
# shellcheck source=tests/node_modules.sh
. "$src/tests/node_modules.sh"

export QUILTD_BUILD=$out QUILTD_NODE=${out%/*}/node CLIENTS_NODE=${out%/*}/clients PYTHONDONTWRITEBYTECODE=1
why=$(node_missing 20)
command -v python3 > /dev/null || why="there is no python3"
[ -n "$why" ] || why=$(tarballs_missing "$src/tests/clients/packages" "$CLIENTS_NODE")
if [ -n "$why" ]; then
    skip "programs that people have" "$why"
    end
fi
CLIENTS_BROWSER=$(browser_missing "$src" "$QUILTD_NODE")
export CLIENTS_BROWSER
top=$(mktemp -d)
trap 'rm -rf "$top"' EXIT
# In a network of their own, if the machine allows it: then the ports are free.
alone=()
inside=(unshare --map-root-user --net bash -c 'ip link set lo up && exec "$@"' -)
! "${inside[@]}" true 2> /dev/null || alone=("${inside[@]}")
for which in ${CLIENTS:-control quiltweb}; do
    "${alone[@]}" node "$src/tests/clients/run.js" "$which" > "$top/log" 2>&1 < /dev/null
    tap_results "$top/log" $? "$which"
done
end
