# Sourced by owt, after setup.sh: says what was found, what is missing and how to get it.

doctor() {
    local python missing part package state needed=0
    row() { printf '%-12s %s\n' "$1" "$2"; }

    if python=$(find_python); then
        row python "$("$python" -c 'import sys; print(sys.version.split()[0], sys.executable)')"
        missing=$(missing_requirements "$python")
    else
        missing="Python 3.11 to 3.13: apt install python3 python3-dev python3-venv"
    fi
    [[ $missing == *headers* || -z $python ]] ||
        row headers "$("$python" -c 'import sysconfig; print(sysconfig.get_path("include"))')"
    [[ $missing == *"venv module"* || -z $python ]] || row venv "module found"
    [[ $missing == *"C++ compiler"* ]] || row compiler "$("${CXX:-g++}" --version | head -n 1)"
    if [[ -x $VENV/bin/python ]]; then
        row environment "$("$VENV/bin/python" --version), $VENV"
    else
        row environment "not made yet: ./owt setup"
    fi
    for part in cmake ninja uv; do
        [[ ! -x $VENV/bin/$part ]] || row "$part" "$(use_environment; "$VENV/bin/$part" --version | head -n 1)"
    done
    if [[ $MODE == wheels ]]; then
        row "ROS 2" "wheels$(use_environment; "$VENV/bin/python" -c 'import importlib.metadata as m
print(", rclpy", m.version("ros-rclpy"))' 2>/dev/null || echo ", not installed yet: ./owt setup")"
    else
        row "ROS 2" "the sourced distribution $MODE"
    fi
    for part in environment messages packages $(kernel_packages); do
        state="up to date"
        case $part in
            environment) up_to_date environment || state="to be made: ./owt setup"; row "lock" "$state" ;;
            messages) up_to_date messages || state="to be built: ./owt setup"; row "owt_msgs" "$state" ;;
            packages) up_to_date packages || state="to be built: ./owt setup"; row "workspace" "$state" ;;
            *) up_to_date "kernels:$part" || state="to be compiled: ./owt setup"; row "kernels" "$part: $state" ;;
        esac
        [[ $state == "up to date" ]] || needed=1
    done
    row disk "$(df -Ph "$ROOT" | awk 'NR == 2 { print $4 " free" }') (environment and build take 1.2 GB)"
    (($(df -Pk "$ROOT" | awk 'NR == 2 { print $4 }') > 2000000)) || [[ -x $VENV/bin/python ]] ||
        missing+=${missing:+$'\n'}"disk space: 2 GB are needed"

    if [[ -n $missing ]]; then
        printf 'error: missing %s\n' "${missing//$'\n'/$'\n'error: missing }" >&2
        return 1
    fi
    ((needed == 0)) || { echo "error: not set up: ./owt setup" >&2; return 1; }
}
