# Sourced by owt: where things are, and the environment that every command of the workspace runs in.

VENV=$ROOT/.venv
INSTALL=$ROOT/install

# "wheels", or the name of a sourced ROS 2 distribution (one of its prefixes holds rclpy).
ros_mode() {
    local prefix prefixes
    if [[ -n ${ROS_DISTRO:-} ]]; then
        IFS=: read -ra prefixes <<<"${AMENT_PREFIX_PATH:-}"
        for prefix in "${prefixes[@]}"; do
            [[ $prefix == "$VENV" || ! -e $prefix/share/ament_index/resource_index/packages/rclpy ]] || {
                echo "$ROS_DISTRO"
                return
            }
        done
    fi
    echo wheels
}

# The ROS wheels restart Python unless LD_LIBRARY_PATH is complete and their marker is set: both are set here, so
# that Python starts once. A sourced distribution has set its own paths already.
use_environment() {
    local folder libraries=$INSTALL/lib:$VENV/lib
    if [[ $MODE == wheels ]]; then
        for folder in "$VENV"/lib/python3.*/site-packages/ros_*.libs; do
            libraries+=:$folder
        done
        export LD_LIBRARY_PATH=$libraries
        export _ROS_WHEELS_BOOTSTRAP_COMPLETE=1
        export AMENT_PREFIX_PATH=$INSTALL:$VENV
        export CMAKE_PREFIX_PATH=$VENV
        unset PYTHONPATH
    else
        [[ :${LD_LIBRARY_PATH:-}: == *:$INSTALL/lib:* ]] ||
            export LD_LIBRARY_PATH=$INSTALL/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
        [[ :$AMENT_PREFIX_PATH: == *:$INSTALL:* ]] || export AMENT_PREFIX_PATH=$INSTALL:$AMENT_PREFIX_PATH
    fi
    export VIRTUAL_ENV=$VENV
    export PATH=$VENV/bin:$PATH
    export ROS_AUTOMATIC_DISCOVERY_RANGE=${ROS_AUTOMATIC_DISCOVERY_RANGE:-LOCALHOST}
    # One BLAS thread: the same bits whatever the machine's load, and faster on blocks of this size.
    export OPENBLAS_NUM_THREADS=${OPENBLAS_NUM_THREADS:-1}
    unset PYTHONHOME
}

# What each part of the set-up was made from. A part is up to date when the text equals its stamp file.
# A subshell, so that the patterns are expanded in the workspace wherever the caller stands.
stamp_of() (
    cd "$ROOT" || exit
    case $1 in
        environment) files=(requirements.lock tools/setup.sh tools/patch_cmake.py tools/site_hook.py) ;;
        messages) files=(requirements.lock .venv/pyvenv.cfg src/owt_msgs/{CMakeLists.txt,package.xml} src/owt_msgs/{msg,srv,action}/*) ;;
        packages)
            files=(requirements.lock .venv/pyvenv.cfg src/*/package.xml src/*/setup.{py,cfg} src/*/resource/*
                src/*/launch/*.py src/*/config/*.yaml)
            ;;
        kernels:*) # numba looks at the time and size of a source file, so that is what counts
            stat -c '%n %.9Y %s' src/"${1#*:}"/"${1#*:}"/kernels{.p[y],/*.py} requirements.lock .venv/pyvenv.cfg
            exit
            ;;
    esac
    echo "$ROOT $MODE"
    sha256sum "${files[@]}"
)

stamp_file() {
    case $1 in
        messages | packages) echo "$INSTALL/.owt/$1" ;;
        *) echo "$VENV/.owt/$1" ;;
    esac
}

kernel_packages() {
    local path
    for path in "$ROOT"/src/*/*/kernels{.py,/__init__.py}; do
        path=${path#"$ROOT"/src/}
        echo "${path%%/*}"
    done
}

up_to_date() {
    local file
    file=$(stamp_file "$1")
    [[ -f $file && $(<"$file") == "$(stamp_of "$1" 2>/dev/null)" ]]
}

write_stamp() {
    local file
    file=$(stamp_file "$1")
    mkdir -p "${file%/*}"
    stamp_of "$1" >"$file.new"
    mv "$file.new" "$file"
}

all_up_to_date() {
    local part package
    [[ -x $VENV/bin/python ]] || return 1
    for part in environment messages packages; do
        up_to_date "$part" || return 1
    done
    for package in $(kernel_packages); do
        up_to_date "kernels:$package" || return 1
    done
}
