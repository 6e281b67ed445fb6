# A Slurm cluster on this machine alone, for a test: sourced by run.sh. Needs root (each node is a PID namespace) and Debian's
# munge, slurmctld, slurmd and slurm-client. Nothing is read from or written to /etc, /run or /var.
#
#   cluster_up N       boots nodes n1 … nN; sets SLURM_CONF
#   node_down n2       pulls the plug: slurmd is the first process of its namespace, and the kernel ends all others with it
#   node_up n2         boots it again
#   cluster_down       ends everything

CLUSTER=
NODE_CPUS=2

cluster_has_tools() {
    local tool
    for tool in munged slurmctld slurmd sbatch squeue sinfo scontrol unshare; do
        command -v "$tool" >/dev/null || { echo "no $tool"; return 1; }
    done
    [[ $(id -u) == 0 ]] || { echo "not root"; return 1; }
    unshare --fork --pid --mount-proc true 2>/dev/null || { echo "no PID namespaces"; return 1; }
}

# The first of so many ports in a row that nobody listens on.
free_ports() {
    local n=$1 first port
    while :; do
        first=$((20000 + RANDOM % 10000))
        for ((port = first; port < first + n; port++)); do
            ! (exec 3<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null || continue 2
        done
        echo "$first"
        return
    done
}

cluster_up() {
    local nodes=$1 port host user
    CLUSTER=$(mktemp -d "${TMPDIR:-/tmp}/etendue-slurm.XXXXXX")
    port=$(free_ports $((nodes + 1))) host=$(hostname -s) user=$(id -un)
    mkdir "$CLUSTER"/{munge,state,spool,log}
    chmod 755 "$CLUSTER"
    chmod 711 "$CLUSTER/munge"
    head -c 128 /dev/urandom >"$CLUSTER/munge/key"
    chmod 600 "$CLUSTER/munge/key"
    # A node that is silent is missed after five seconds, and what it ran is sent again when its credential has run out: five
    # seconds here instead of two minutes. No task is repeated because it failed.
    cat >"$CLUSTER/slurm.conf" <<CONF
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
AuthInfo=socket=$CLUSTER/munge/socket,cred_expire=5
CredType=cred/munge
StateSaveLocation=$CLUSTER/state
SlurmdSpoolDir=$CLUSTER/spool/%n
SlurmctldPidFile=$CLUSTER/state/pid
SlurmdPidFile=$CLUSTER/spool/%n.pid
SlurmctldLogFile=$CLUSTER/log/slurmctld
SlurmdLogFile=$CLUSTER/log/%n
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MailProg=/bin/true
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerType=sched/backfill
SchedulerParameters=sched_interval=1,sched_min_interval=0,batch_sched_delay=0,bf_interval=1,default_queue_depth=1000,partition_job_depth=1000
SlurmdParameters=config_overrides
SlurmdTimeout=5
MessageTimeout=3
KillWait=2
ReturnToService=2
MaxArraySize=10001
NodeName=n[1-$nodes] NodeHostname=$host NodeAddr=127.0.0.1 Port=[$((port + 1))-$((port + nodes))] CPUs=$NODE_CPUS RealMemory=8000 State=UNKNOWN
PartitionName=main Nodes=n[1-$nodes] Default=YES MaxTime=INFINITE State=UP
CONF
    echo 'CgroupPlugin=cgroup/v1' >"$CLUSTER/cgroup.conf"
    export SLURM_CONF=$CLUSTER/slurm.conf
    setsid munged -F --key-file="$CLUSTER/munge/key" --socket="$CLUSTER/munge/socket" --pid-file="$CLUSTER/munge/pid" \
        --seed-file="$CLUSTER/munge/seed" --log-file="$CLUSTER/log/munged" </dev/null >/dev/null 2>&1 &
    keep munged
    wait_for 20 test -S "$CLUSTER/munge/socket" || return 1
    setsid slurmctld -D -c -f "$SLURM_CONF" </dev/null >"$CLUSTER/log/out" 2>&1 &
    keep slurmctld
    wait_for 20 eval 'scontrol ping 2>/dev/null | grep -q "is UP"' || return 1
    local k
    for ((k = 1; k <= nodes; k++)); do node_up "n$k"; done
    wait_for 30 eval '[[ $(sinfo -h -N -o %T 2>/dev/null | grep -cx idle) == '"$nodes"' ]]'
}

# Remembers who was started last; nothing is said when he is ended.
keep() {
    echo $! >"$CLUSTER/$1.pid"
    disown
}

# Seconds, then a command that is tried until it succeeds.
wait_for() {
    local end=$((SECONDS + $1))
    shift
    until "$@"; do
        ((SECONDS < end)) || return 1
        sleep 0.1
    done
}

node_up() {
    mkdir -p "$CLUSTER/spool/$1"
    setsid unshare --fork --pid --mount-proc --kill-child=KILL slurmd -D -f "$SLURM_CONF" -N "$1" \
        </dev/null >"$CLUSTER/log/$1.out" 2>&1 &
    keep "$1"
}

node_down() {
    kill -KILL "$(<"$CLUSTER/$1.pid")" 2>/dev/null || true
    rm -f "$CLUSTER/$1.pid"
}

cluster_down() {
    [[ -n $CLUSTER ]] || return 0
    local pid
    for pid in "$CLUSTER"/n*.pid "$CLUSTER"/slurmctld.pid "$CLUSTER"/munged.pid; do
        [[ ! -e $pid ]] || kill -KILL "$(<"$pid")" 2>/dev/null || true
    done
    sleep 0.2
    rm -rf "$CLUSTER"
    CLUSTER=
}
