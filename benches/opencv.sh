# Sourced by the scripts that measure beside OpenCV: makes the virtual environment under target/, builds gpu-stereo unless
# --binary names one, and starts the Python program of the script's name.
set -euo pipefail
name=$(basename "$0")
root=$(cd "$(dirname "$0")/.." && pwd)

# Pinned: a figure of an unknown version says nothing.
opencv=5.0.0.93
numpy=2.4.6

work="$root/target/opencv"
python="$work/venv/bin/python"

installed() {
    [[ -x $python ]] && "$python" - "$opencv" "$numpy" 2>/dev/null <<'PYTHON'
import sys
from importlib.metadata import version
assert [version("opencv-contrib-python-headless"), version("numpy")] == sys.argv[1:]
PYTHON
}

build=yes
for argument in "$@"; do
    case $argument in
    --binary | --binary=* | -h | --help) build=no ;;
    esac
done

if ! installed; then
    echo "$name: installing opencv-contrib-python-headless $opencv and numpy $numpy in $work/venv" >&2
    mkdir -p "$work"
    python3 -m venv --clear "$work/venv"
    "$python" -m pip install --quiet --only-binary :all: "opencv-contrib-python-headless==$opencv" "numpy==$numpy"
fi

if [[ $build == yes ]]; then
    target=${CARGO_TARGET_DIR:-$root/target}
    (cd "$root" && CARGO_TARGET_DIR=$target cargo build --release --locked --bin gpu-stereo)
    set -- --binary "$target/release/gpu-stereo" "$@"
fi
exec "$python" "$root/benches/$name.py" "$@"
