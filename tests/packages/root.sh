# A bare Debian in a folder, for the tests of packages, which source this file. It is the Debian of this machine, for which
# its packages are, unless $suite names another one. Root and the network are needed.
suite=$(. /etc/os-release && echo "${VERSION_CODENAME:-}")
skip() { echo "SKIPPED: $*"; exit 77; }
fail() { echo "FAILED: $*" >&2; exit 1; }

# need_root ARCHITECTURE: whether a root of this architecture can be made and entered.
need_root() {
  [ "$(id -u)" = 0 ] || skip "a chroot needs root"
  [ "$suite" = bookworm ] || [ "$suite" = trixie ] || skip "this machine is neither Debian 12 nor Debian 13"
  command -v debootstrap >/dev/null || skip "debootstrap is not installed (bsp/install-packages long)"
  [ "$1" != "$(dpkg --print-architecture)" ] || return 0
  [ "$1" = arm64 ] || skip "no emulator is known for $1"
  command -v qemu-aarch64-static >/dev/null || skip "qemu-user-static is not installed (bsp/install-packages aarch64)"
  local formats=/proc/sys/fs/binfmt_misc
  [ -e $formats/register ] || mount -t binfmt_misc binfmt_misc $formats 2>/dev/null ||
    skip "this kernel cannot start programs of $1: it has no binfmt_misc"
  [ ! -e $formats/qemu-aarch64 ] || return 0
  # The interpreter is opened now (F), so that it needs no file in the root.
  local magic='\x7f\x45\x4c\x46\x02\x01\x01\x00\x00\x00\x00\x00\x00\x00\x00\x00\x02\x00\xb7\x00'
  local mask='\xff\xff\xff\xff\xff\xff\xff\x00\xff\xff\xff\xff\xff\xff\xff\xff\xfe\xff\xff\xff'
  echo ":qemu-aarch64:M::$magic:$mask:$(command -v qemu-aarch64-static):F" >$formats/register ||
    skip "this kernel takes no emulator for $1"
}

# make_root ARCHITECTURE FOLDER PACKAGES: a new root with these packages (comma between names) beside the essential ones.
# FOLDER.tar keeps it for the next time, because an emulated installation takes long.
make_root() {
  local architecture=$1 root=$2 packages=$3 source log without=
  log=$root.log
  rm -rf --one-file-system "$root"
  if [ ! -s "$root.tar" ]; then
    # Its installation starts thousands of processes, and nothing here needs it.
    [ "$architecture" = "$(dpkg --print-architecture)" ] || without=--exclude=tzdata
    source=$(awk '/^URIs:/{print $2; exit}' /etc/apt/sources.list.d/debian.sources 2>/dev/null || true)
    debootstrap --arch "$architecture" --variant=minbase --include="$packages" $without "$suite" "$root" \
      "${source:-http://deb.debian.org/debian}" >"$log" 2>&1 || skip "debootstrap has no Debian to install: $log"
    tar -C "$root" --one-file-system --numeric-owner -cf "$root.tar.part" . && mv "$root.tar.part" "$root.tar"
    rm -rf --one-file-system "$root"
  fi
  mkdir -p "$root"
  tar -C "$root" --numeric-owner -xpf "$root.tar"
  cp -rL /etc/apt/apt.conf.d/99* "$root/etc/apt/apt.conf.d/" 2>/dev/null || true
  cp -rL /etc/ssl/certs/. "$root/etc/ssl/certs/" 2>/dev/null || true
  cp -L /etc/resolv.conf /etc/hosts "$root/etc/"
}

# inside COMMAND...: in $root, with an environment of its own.
inside() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }
