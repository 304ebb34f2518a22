# Sourced by owt: builds .venv, build/, install/ and the kernel caches. Each part writes its stamp last, so an
# interrupted set-up starts again where it stopped.

LOG=$ROOT/log/setup.log

say() {
    local now=$EPOCHREALTIME
    local tenths=$(((${now/[.,]/} - ${BEGIN/[.,]/}) / 100000))
    printf '[%4d.%d s] %s\n' $((tenths / 10)) $((tenths % 10)) "$*" >&2
}

fail() {
    echo "error: $*" >&2
    exit 1
}

# Run a command with its output in the log.
attempt() {
    printf '\n== %s\n' "$1" >>"$LOG"
    "${@:2}" >>"$LOG" 2>&1 9>&-
}

# The same; on failure show the end of the log and stop.
logged() {
    attempt "$@" && return
    tail -n 25 "$LOG" >&2
    fail "$1 failed; the whole output is in log/setup.log"
}

# A Python from 3.11 to 3.13; OWT_PYTHON names another.
find_python() {
    local candidate
    for candidate in ${OWT_PYTHON:-python3.11 python3 python3.12 python3.13}; do
        "$candidate" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' 2>/dev/null && {
            echo "$candidate"
            return
        }
    done
    return 1
}

# What set-up needs from the system; one line per missing thing. Doctor asks the same question.
missing_requirements() {
    local python=$1
    "$python" -c 'import ensurepip, venv' 2>/dev/null ||
        echo "the venv module of Python: apt install python3-venv"
    "$python" -c 'import pathlib, sys, sysconfig
sys.exit(not (pathlib.Path(sysconfig.get_path("include")) / "Python.h").is_file())' ||
        echo "the headers of Python (Python.h): apt install python3-dev"
    command -v "${CXX:-g++}" >/dev/null || echo "a C++ compiler (${CXX:-g++}): apt install g++"
    command -v "${CC:-gcc}" >/dev/null || echo "a C compiler (${CC:-gcc}): apt install gcc"
    if [[ $MODE == wheels ]]; then
        [[ $(uname -sm) == "Linux x86_64" ]] ||
            echo "Linux on x86_64 (this is $(uname -sm)), for which the ROS 2 wheels are built; elsewhere source a ROS 2 distribution"
    else
        "$python" -c 'import rclpy' 2>/dev/null ||
            echo "rclpy of ROS 2 $MODE, importable by $python: source its setup.bash, or open a shell without it"
        command -v colcon >/dev/null || echo "colcon: apt install python3-colcon-common-extensions"
    fi
}

# The lock, without what a sourced distribution brings itself.
lock_for_mode() {
    if [[ $MODE == wheels ]]; then
        cat "$ROOT/requirements.lock"
    else
        awk '/^[A-Za-z0-9]/ { keep = !/^(ros-|colcon-|catkin-pkg=|empy=|lark=|lark-parser=)/ } keep' "$ROOT/requirements.lock"
    fi
}

# Always from scratch: an environment is cheap to make, and the ROS wheels cannot be updated in place (several of them
# carry a second name, which the installer's clean-up would take for a stray package and remove).
make_environment() {
    local python site_packages lock=$VENV/.owt/requirements.lock flags=()
    python=$(find_python) || fail "missing Python 3.11 to 3.13: apt install python3 python3-dev python3-venv"
    report_missing "$python"
    local PYTHONPATH= # exported if it was: a distribution's own packages must not count as installed
    say "virtual environment: $("$python" --version)"
    rm -rf "$VENV" "$ROOT/build" "$INSTALL"
    mkdir -p "$VENV/.owt"
    [[ $MODE == wheels ]] || flags=(--system-site-packages)
    logged "making the virtual environment" "$python" -m venv "${flags[@]}" "$VENV"
    site_packages=$(echo "$VENV"/lib/python3.*/site-packages)

    say "package installer: uv"
    lock_for_mode >"$lock"
    awk '/^[A-Za-z0-9]/ { keep = /^uv==/ } keep' "$lock" >"$VENV/.owt/uv.lock"
    logged "installing uv" "$VENV/bin/python" -m pip install --quiet --disable-pip-version-check --no-deps \
        --require-hashes -r "$VENV/.owt/uv.lock"
    say "packages: $(grep -c '^[A-Za-z0-9]' "$lock") pinned"
    # copies, not links: the patch below must never reach uv's cache; certificates: those of the system, as pip's
    if ! UV_LINK_MODE=copy UV_SYSTEM_CERTS=1 attempt "installing the packages with uv" "$VENV/bin/uv" pip install --python "$VENV/bin/python" \
        --no-deps --require-hashes --compile-bytecode -r "$lock"; then
        say "uv failed (see log/setup.log); trying pip, which knows its own index settings"
        logged "installing the packages" "$VENV/bin/python" -m pip install --disable-pip-version-check --no-deps \
            --require-hashes -r "$lock"
    fi

    write_paths
    if [[ $MODE == wheels ]]; then
        cp "$ROOT/tools/site_hook.py" "$site_packages/_owt_site.py"
        logged "patching the ROS wheels' CMake files" "$VENV/bin/python" "$ROOT/tools/patch_cmake.py"
    fi
    write_stamp environment
}

# Python finds the packages where they lie.
write_paths() {
    local site_packages
    site_packages=$(echo "$VENV"/lib/python3.*/site-packages)
    {
        printf '%s\n' "$ROOT"/src/*/setup.py | sed 's,/setup.py$,,'
        echo "$INSTALL/lib/${site_packages#"$VENV"/lib/}"
        [[ $MODE != wheels ]] || echo "import _owt_site"
    } >"$site_packages/owt.pth"
}

report_missing() {
    local missing
    missing=$(missing_requirements "$1")
    [[ -z $missing ]] || fail "missing ${missing//$'\n'/; missing }"
}

colcon_build() {
    local colcon=("$VENV/bin/colcon") cmake=(-GNinja -DBUILD_TESTING=OFF "-DPython3_EXECUTABLE=$VENV/bin/python"
        -DPython3_FIND_VIRTUALENV=ONLY)
    if [[ $MODE == wheels ]]; then
        cmake+=("-DCMAKE_PREFIX_PATH=$VENV")
    else # run by the environment's Python, whose path then stands in the executables
        colcon=("$VENV/bin/python" "$(PATH=${PATH#"$VENV/bin:"} command -v colcon)")
    fi
    cd "$ROOT"
    # without -j, colcon also limits the load and leaves cores idle
    MAKEFLAGS=-j$(nproc) logged "colcon build" "${colcon[@]}" build --merge-install "$@" --cmake-args "${cmake[@]}"
    cd "$OLDPWD"
}

build_workspace() {
    local select=()
    write_paths # a package may be new
    if up_to_date packages; then
        select=(--packages-select owt_msgs)
        say "workspace: owt_msgs (colcon)"
    elif up_to_date messages; then
        select=(--packages-skip owt_msgs)
        say "workspace: Python packages (colcon)"
    else
        say "workspace: all packages (colcon)"
    fi
    colcon_build "${select[@]}"
    write_stamp messages
    write_stamp packages
}

# numba does not see that a kernel calls another one that changed: all caches of a changed package go.
compile_kernels() {
    local package
    for package in "$@"; do
        find "$ROOT/src/$package" \( -name '*.nbi' -o -name '*.nbc' \) -delete
    done
    if [[ -f $ROOT/src/owt_bringup/owt_bringup/warmup.py ]]; then
        say "numba kernels: $*"
        logged "compiling the kernels" "$VENV/bin/python" -m owt_bringup.warmup
    fi
    for package in "$@"; do
        write_stamp "kernels:$package"
    done
}

set_up() {
    local package stale=()
    BEGIN=$EPOCHREALTIME
    mkdir -p "$ROOT/log"
    exec 9>>"$ROOT/.setup.lock"
    flock -n 9 || {
        say "waiting for another set-up of this workspace"
        flock 9
    }
    date -u +'== set-up of %Y-%m-%d %H:%M:%S UTC' >>"$LOG"
    up_to_date environment && [[ -x $VENV/bin/python ]] || make_environment
    use_environment
    up_to_date messages && up_to_date packages || build_workspace
    for package in $(kernel_packages); do
        up_to_date "kernels:$package" || stale+=("$package")
    done
    ((${#stale[@]} == 0)) || compile_kernels "${stale[@]}"
    say "ready"
    exec 9>&-
}
