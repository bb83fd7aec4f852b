#!/bin/bash
# shellcheck disable=SC2317  # functions are called by others
# quiltfarm on a Slurm cluster of three simulated nodes (tests/farm/slurm) and by GNU parallel, with the faults of a farm: a task that is
# told to end, one that is requeued, a node that is lost, a program that is killed, a task that runs twice, and one that can never succeed.
# Whatever the faults, the files must have the bytes of a single run. Every wait has an end, and fails with the logs.
set -u
src=$(cd "${QUILTD_SOURCE:-.}" && pwd)
out=$(cd "${QUILTD_BUILD:-build/release}" && pwd)
# shellcheck source=tests/report.sh
. "$src/tests/report.sh"

top=$(mktemp -d)
top=$(cd "$top" && pwd -P)
chmod 755 "$top" # for munge
cluster=$top/cluster
mkdir "$cluster" "$top/bin" "$top/fake" "$top/hold"
leave() {
    rm -f "$top"/hold/*
    [ ! -e "$cluster/slurm.conf" ] || "$src/tests/farm/slurm" stop "$cluster"
    # what a failed test left, known by its folder
    local p
    for p in /proc/[0-9]*; do
        case $(readlink "$p/cwd" 2> /dev/null) in "$top" | "$top"/*) [ "$p" = "/proc/$$" ] || kill -9 "${p#/proc/}" 2> /dev/null ;; esac
    done
    rm -rf "$top"
}
trap leave EXIT
cd "$top" || exit 1

# ------------------------------------------------------------------------------------------------ what is rendered --

cat > plate.json << 'END'
{"quiltd": 1,
 "camera": {"position": [0, 0, 1.9], "target": [0, 0, 0], "fov_y": 60, "view_blur": 1, "views": {"grid": {"columns": 9, "rows": 7, "width": 1.2, "height": 0.8, "window": "own"}}},
 "volumes": {"fog": {"shape": "sphere", "density": 4, "albedo": 0.9}},
 "lights": {"sky": {"type": "environment", "radiance": 0.7}}}
END
plate=(plate.json --hologram views --view-size 32x24 --spp 96)
"$out/quiltrender" "${plate[@]}" -o single/ --threads 1 2> single.log || { cat single.log; exit 1; }

# three frames of smoke
for k in 1 2 3; do cp -L "$(dirname "$out")/scenes/cloud.vdb" "s_000$k.vdb" || exit; done
cat > frames.json << 'END'
{"quiltd": 1, "camera": {"position": [0, 0, 4], "target": [0, 0, 0], "views": 3, "cone": 20},
 "volumes": {"smoke": {"file": "s_%04d.vdb", "sequence": {"missing": "error"}, "scale": 4, "albedo": 0.9}}, "lights": {"sky": {"type": "environment", "radiance": 0.7}}}
END
frames=(frames.json --quilt 3x1 --view-size 32x24 --passes 2)

# quiltfarm finds the renderer in its own folder: bin/ has the real one, fake/ a stand-in. A task of bin/ whose file hold/task_K
# exists stops after its beginning until the file is removed. hold/task_K.pid is then the number of the renderer.
cp "$out/quiltfarm" bin/
cp "$out/quiltfarm" "$src"/tests/farm/fake/* fake/
cp "$src/tests/farm/scene.json" bands.json
ln -s "$out/quiltmerge" bin/quiltmerge
cat > bin/quiltrender << END
#!/bin/sh
task=none
for word in "\$@"; do
    case \$word in */states/task_*) task=\${word##*/} task=\${task%%.*} ;; esac
done
[ -e "$top/hold/\$task" ] || exec "$out/quiltrender" "\$@"
"$out/quiltrender" "\$@" &
child=\$!
end() {
    kill -CONT \$child 2> /dev/null
    kill -TERM \$child 2> /dev/null
    wait \$child
    exit \$?
}
trap end TERM INT
# for a tenth of a second of CPU time, of the seven or so that it needs
ticks() { sed 's/.*) //' /proc/\$child/stat 2> /dev/null | { read -r _ _ _ _ _ _ _ _ _ _ _ user system _ && echo \$((user + system)); } }
while [ "\$(ticks || echo 99)" -lt 10 ]; do sleep 0.02; done
kill -STOP \$child
echo \$child > "$top/hold/\$task.new"
mv "$top/hold/\$task.new" "$top/hold/\$task.pid"
while [ -e "$top/hold/\$task" ] && grep -q '^State:.[^XZ]' /proc/\$child/status; do sleep 0.1; done
kill -CONT \$child 2> /dev/null
wait \$child
END
chmod +x bin/quiltrender

# ------------------------------------------------------------------------------------------------------- the waits --

logs() {
    squeue -r 2> /dev/null
    tail -n 5 "$top"/*.job/log/*.log "$top"/*.job/done/*.failed "$cluster"/log/*.log 2> /dev/null
}
wait_for() { # what, command…
    local what=$1 left=${FARM_PATIENCE:-3000} # tenths of a second
    shift
    until "$@"; do
        left=$((left - 1))
        if [ "$left" -eq 0 ]; then
            report "$what" "waited for too long in ${FUNCNAME[1]}: $*"
            logs
            end
        fi
        sleep 0.1
    done
}
is_held() { [ -e "$top/hold/task_$1.pid" ]; }
# (commands of Slurm fail now and then on a machine with other work)
is_empty() { q=$(squeue -h 2> /dev/null) && [ -z "$q" ]; }
has_ended() { ! kill -0 "$1" 2> /dev/null; }
hold() { for k in "$@"; do : > "hold/task_$k"; done; }
release() { for k in "$@"; do rm -f "hold/task_$k" "hold/task_$k.pid"; done; }
state() { bin/quiltfarm status "$1" --json 2> /dev/null | sed -n 's/^  "state": "\(.*\)",$/\1/p'; }
expect_state() { [ "$(state "$1")" = "$2" ] || { bin/quiltfarm status "$1"; echo "expected $2"; }; }
has_words() { grep -qF -- "$2" "$1" || { echo "$1 lacks \"$2\":"; tail -n 5 "$1"; }; }
same() { diff -r single "$1" 2>&1; }
half_written() { find "$1" -name '.?*quiltd-*' -o -name '*.new' -o -size 0 -name 'f_*'; }
no_states() { find "$1/states" -type f; }

# ------------------------------------------------------------------------------------------------------------ list --

# What is small is one task, whose command must still be that of the whole job.
by_list() { # name, words of quiltrender
    local name=$1
    shift
    if ! { bin/quiltfarm plan "$name.job" --engine list --threads 1 ${minutes:+--task-minutes $minutes} -- "$@" && sh -e "$name.job/tasks" && bin/quiltfarm merge "$name.job"; } > list.log 2>&1; then
        cat list.log
    fi
    expect_state "$name.job" complete
}
report "a small plate is one task, and has its manifest" "$(by_list one "${plate[@]}" -o one/; same one)"
report "rows of a plate are made without it" "$(by_list rows "${plate[@]}" -o rows/ --camera-rows 0:1; ls rows/manifest.json 2> /dev/null; diff -rq single rows | grep -v '^Only in single')"
sed 's/0.9/0.8/' plate.json > edited.json
bin/quiltfarm plan edited.job --engine list --threads 1 -- edited.json "${plate[@]:1}" -o edited/ > edited.log 2>&1
sed -i 's/0.8/0.7/' edited.json
report "a scene that is edited after the plan is told" "$(sh edited.job/tasks 2> edited.log && echo 'it was rendered'; has_words edited.log 'edited.json: has changed since the job was planned'; ls edited 2> /dev/null)"
if command -v ffmpeg > /dev/null; then
    film=("${frames[@]}" --frames 2:3)
    report "frames of a film are those of the command" "$("$out/quiltrender" "${film[@]}" -o film.mp4 2> film.log || cat film.log; by_list joined "${film[@]}" -o joined.mp4; cmp film_*.mp4 joined_*.mp4 2>&1)"
    minutes=0
    report "frames that were tasks make the same film" "$(by_list apart "${film[@]}" -o apart.mp4; [ "$(wc -l < apart.job/tasks)" -eq 2 ] || cat apart.job/tasks; cmp film_*.mp4 apart_*.mp4 2>&1)"
else
    skip "frames of a film are those of the command" "ffmpeg is not installed"
fi

# -------------------------------------------------------------------------------------------------------- parallel --

by_parallel() {
    bin/quiltfarm plan parallel.job --engine parallel --threads 1 --task-minutes 0.005 -- "${plate[@]}" -o parallel/ > parallel.log 2>&1
    report "a plan tells the cost" "$(for w in 'CPU time' 'tasks at once' 'of memory' 'of states'; do has_words parallel.log "$w"; done)"
    hold 0 1 2
    bin/quiltfarm submit parallel.job --slots 3 2> parallel.log &
    local submit=$!
    for k in 0 1 2; do wait_for "a task begins" is_held "$k"; done
    bin/quiltfarm submit parallel.job 2> second.log
    report "a second submission is refused" "$(has_words second.log 'another quiltfarm works on it')"
    report "status shows a running job" "$(expect_state parallel.job running)"
    bin/quiltfarm task parallel.job 2 2> twice.log &
    local twice=$!
    kill -TERM "$(sed -n 's/.*"pid": \([0-9]*\).*/\1/p' parallel.job/done/task_0.running)"
    kill -9 "$(cat hold/task_1.pid)"
    has_failed() { [ -e parallel.job/done/task_1.failed ]; }
    wait_for "a killed task has failed" has_failed
    report "a killed task leaves its words" "$(has_words parallel.job/done/task_1.failed 'was killed')"
    release 0 1 2
    wait_for "the second run ends" has_ended $twice
    bin/quiltfarm cancel parallel.job
    wait_for "a cancelled submission ends" has_ended $submit
    wait $submit
    local code=$?
    report "a cancelled job is interrupted" "$([ $code -eq 75 ] || { echo "exit status $code"; cat parallel.log; })"
    # GNU parallel ends a little before the last of the tasks that it has told to
    none_run() { ! bin/quiltfarm status parallel.job --json | grep -q '"running": [1-9]'; }
    wait_for "the last task of a cancelled submission ends" none_run
    bin/quiltfarm resume parallel.job 2> parallel.log || cat parallel.log
    report "GNU parallel makes the bytes of a single run" "$(expect_state parallel.job complete; same parallel; no_states parallel.job)"
}

# The hosts are this one; ssh is a shell. As sshd does, it sets SHELL, by which GNU parallel starts a command.
by_ssh() {
    cat > ssh << 'END'
#!/bin/sh
while [ "${1#-}" != "$1" ]; do
    case $1 in -l | -o | -p) shift ;; esac
    shift
done
shift
[ "$1" != -- ] || shift
SHELL=/bin/sh exec sh -c "$*"
END
    chmod +x ssh
    fake/quiltfarm plan ssh.job --engine parallel --threads 1 -- bands.json -o ssh-bands > /dev/null
    fake/quiltfarm submit ssh.job -- -S one,two --ssh "$top/ssh" 2> ssh.log || cat ssh.log
    report "hosts over ssh render it" "$(expect_state ssh.job complete; diff -r bands ssh-bands)"
}
never_by_parallel() {
    sed 's/^{/{"fail": "gone.vdb: there is no such file", /' "$src/tests/farm/scene.json" > never.json
    fake/quiltfarm plan never.job --engine parallel --threads 1 -- never.json -o never > /dev/null
    fake/quiltfarm submit never.job 2> never.log
    report "GNU parallel: a job that cannot succeed fails with its words" "$(has_words never.log 'gone.vdb: there is no such file'; expect_state never.job failed; half_written never.job; find . -path './never/*')"
}

fake/quiltrender bands.json -o bands --camera-rows 0:2 2> /dev/null
if command -v parallel > /dev/null && parallel --version 2> /dev/null | grep -q '^GNU parallel'; then
    by_parallel
    by_ssh
    never_by_parallel
else
    skip "GNU parallel" "parallel is not installed"
fi

# ----------------------------------------------------------------------------------------------------------- Slurm --

why=$("$src/tests/farm/slurm" check "$cluster")
if [ -n "$why" ]; then
    skip "Slurm" "$why"
    end
fi
if ! "$src/tests/farm/slurm" start "$cluster" 3 > start.log 2>&1; then
    report "a Slurm cluster starts" "$(cat start.log)"
    end
fi
export SLURM_CONF=$cluster/slurm.conf

# The job of a running task, "12_3", and its node.
job_of() { squeue -h -r -t R -o '%F_%K %j' | sed -n "s/^\([0-9]*_$1\) plate_job-.*/\1/p"; }
node_of() { squeue -h -r -t R -o '%K %N %j' | sed -n "s/^$1 \([^ ]*\) plate_job-.*/\1/p" | head -n 1; }
is_down() { sinfo -h -n "$1" -o %T | grep -q down; }

on_slurm() {
    rm -f hold/* # a renderer that was released may have written its number later
    hold 0 1 2 3 4
    bin/quiltfarm plan plate.job --threads 1 --task-minutes 0 -- "${plate[@]}" -o plate/ > plan.log 2>&1 || cat plan.log
    bin/quiltfarm submit plate.job 2> submit.log || cat submit.log
    report "more tasks than an array may have become two" "$(n=$(squeue -h -r -o '%F %K' | grep -vc N/A); [ "$n" -eq 7 ] || squeue -r)"
    report "a second submission is refused" "$(bin/quiltfarm submit plate.job > second.log 2>&1; has_words second.log 'was submitted already')"
    for k in 0 1 2; do wait_for "a task begins" is_held "$k"; done
    report "status shows a running job" "$(expect_state plate.job running)"

    local lost first second
    find_jobs() { lost=$(node_of 2) first=$(job_of 0) second=$(job_of 1) && [ -n "$lost" ] && [ -n "$first" ] && [ -n "$second" ]; }
    requeue() { scontrol requeue "$second" 2> /dev/null; }
    wait_for "three tasks run" find_jobs
    timeout 2 scancel --quiet --batch --signal=TERM "$first" || true # it may wait for the requeued job
    wait_for "a task is requeued" requeue
    "$src/tests/farm/slurm" lose "$cluster" "$lost"
    release 0 1 2
    fake/quiltfarm plan bands.job --threads 1 -- bands.json -o slurm-bands > /dev/null
    fake/quiltfarm submit bands.job 2> bands.log || cat bands.log

    wait_for "a task begins" is_held 4
    bin/quiltfarm task plate.job 4 2> twice.log &
    local twice=$!
    wait_for "a task begins" is_held 3
    kill -9 "$(cat hold/task_3.pid)"
    wait_for "the lost node is down" is_down "$lost"
    "$src/tests/farm/slurm" back "$cluster" "$lost"
    release 3 4
    wait_for "the second run ends" has_ended $twice
    wait_for "the queue is empty" is_empty

    report "a killed task fails with its words" "$(expect_state plate.job failed; bin/quiltfarm status plate.job > status.log; has_words status.log 'failed    task 3, 1 time:'; has_words status.log 'was killed')"
    report "only it is missing" "$(bin/quiltfarm status plate.job --json > status.log; has_words status.log '"complete": 6,')"
    report "the manifest waits for it" "$(find plate -name manifest.json)"
    bin/quiltfarm resume plate.job 2> resume.log || cat resume.log
    report "only it is sent again" "$([ "$(squeue -h -r -o %K | sort | tr '\n' ' ')" = '3 N/A ' ] || squeue -r)"
    wait_for "the queue is empty" is_empty
    report "a cluster with all these faults makes the bytes of a single run" "$(expect_state plate.job complete; same plate; no_states plate.job)"
    report "bands of rows are merged by finishes of their own" "$(expect_state bands.job complete; diff -r bands slurm-bands; no_states bands.job)"
}

# A frame whose file has gone since the plan.
never_on_slurm() {
    bin/quiltfarm plan frames.job --threads 1 --task-minutes 0 -- "${frames[@]}" -o 'f_%04d.png' --frames 1:3 > plan.log 2>&1 || cat plan.log
    mv s_0002.vdb away
    bin/quiltfarm submit frames.job 2> submit.log || cat submit.log
    wait_for "the queue is empty" is_empty
    report "a task that cannot succeed ends with its words" "$(expect_state frames.job failed; bin/quiltfarm status frames.job > status.log; has_words status.log 'failed    task 1, 1 time:'; has_words status.log 's_0002.vdb')"
    report "nothing is half written" "$(half_written .; find . -name '*f_0002*'; [ "$(find . -name 'f_000[13]*.png' | wc -l)" -eq 2 ] || find . -name '*f_000*')"
    for _ in 1 2; do
        bin/quiltfarm submit frames.job 2> submit.log || cat submit.log
        wait_for "the queue is empty" is_empty
    done
    bin/quiltfarm submit frames.job 2> submit.log
    report "it is not sent a fourth time" "$(has_words submit.log '1 step is given up'; is_empty || squeue)"
    mv away s_0002.vdb
    bin/quiltfarm resume frames.job 2> submit.log || cat submit.log
    bin/quiltfarm cancel frames.job 2> cancel.log || cat cancel.log
    wait_for "the queue is empty" is_empty
    report "a cancelled job leaves the queue" "$(case $(state frames.job) in interrupted | complete) ;; *) bin/quiltfarm status frames.job ;; esac)"
}

# Tasks that run are cancelled, by scancel alone and by quiltfarm. A task that returned to the queue would be seen there: it waits
# for 6 seconds, and then runs until a file exists.
cancelled_on_slurm() {
    sed 's/"wait": 0.01/"until": "now"/' "$src/tests/farm/scene.json" > until.json
    fake/quiltfarm plan cancel.job --threads 1 -- until.json -o cancel-bands > /dev/null
    three_run() { [ "$(squeue -h -r -t R -o %j | grep -c ^cancel_job-)" -eq 3 ] && [ "$(cat cancel.job/log/task_*.log | grep -c 'from pass')" -ge "$1" ]; }
    local by name
    for by in scancel quiltfarm; do
        fake/quiltfarm submit cancel.job 2> cancel.log || cat cancel.log
        wait_for "three tasks run" three_run "$([ "$by" = scancel ] && echo 3 || echo 6)"
        name=$(squeue -h -o %j | grep -m 1 ^cancel_job-)
        if [ $by = scancel ]; then scancel --name="$name"; else fake/quiltfarm cancel cancel.job 2> cancel.log || cat cancel.log; fi
        wait_for "tasks that $by cancelled end" is_empty
        sleep 3
        report "tasks that run are cancelled by $by" "$(is_empty || squeue -r; expect_state cancel.job interrupted; [ "$(find cancel.job/states -name 'task_*' | wc -l)" -ge 3 ] || ls cancel.job/states)"
    done
    : > now
    fake/quiltfarm resume cancel.job 2> cancel.log || cat cancel.log
    wait_for "the queue is empty" is_empty
    report "a cancelled job can be resumed" "$(expect_state cancel.job complete; diff -r bands cancel-bands)"
}

on_slurm
never_on_slurm
cancelled_on_slurm
end
