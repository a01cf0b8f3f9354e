# Prints where the standard library's sources of this compiler's version are; if they are not there yet, unpacks them from the backports of
# the system's Debian mirror.
standard_library() {
    local version dir=$PWD/target/rust-src mirror package sources
    version=$(rustc --version | cut -d' ' -f2)
    sources=$dir/usr/src/rustc-$version/library
    if [[ -d $sources ]]; then
        echo "$sources"
        return
    fi
    rm -rf "$dir"
    mkdir -p "$dir/lists/partial" "$dir/cache/archives/partial"
    mirror=$(apt-get indextargets --format '$(ORIGIN) $(LABEL) $(REPO_URI)' | sed -n 's/^Debian Debian //p' | sort -u | head -n 1)
    [[ -n $mirror ]] || return 1
    echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $mirror trixie-backports main" >"$dir/sources"
    local apt=(-qq -o "Dir::Etc::sourcelist=$dir/sources" -o Dir::Etc::sourceparts=- -o "Dir::State::lists=$dir/lists"
        -o "Dir::Cache=$dir/cache" -o APT::Sandbox::User=)
    apt-get "${apt[@]}" update >&2 || return 1
    package=$(apt-cache "${apt[@]}" madison rust-src |
        awk -v version="$version" 'index($3, version "+") == 1 { print $3; exit }')
    [[ -n $package ]] || return 1
    (cd "$dir" && apt-get "${apt[@]}" download "rust-src=$package" && dpkg -x rust-src_*.deb .) >&2 || return 1
    echo "$sources"
}
