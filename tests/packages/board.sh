# A Debian with systemd on the emulated board (qemu-system-aarch64 with Debian's arm64 kernel), for the tests of packages,
# which source this file after root.sh. They fail by the board's clock only: a host that gives the board too little of its
# time ends a test as skipped. $folder is the test's own; no port, name or file is shared with another board.
board_s=900
host_s=2400

# need_board: kernel and first programs, in $folder.
need_board() {
  need_root arm64
  command -v qemu-system-aarch64 >/dev/null || skip "qemu-system-arm is not installed (bsp/install-packages board)"
  kernel=$folder/kernel
  mkdir -p "$folder"
  "$top/bsp/emulated-board/kernel" "$kernel" >"$folder/kernel.log" 2>&1 || skip "Debian's arm64 kernel cannot be fetched: $folder/kernel.log"
  [ ! -s "$folder/busybox" ] || return 0
  (cd "$folder" && apt-get -qq -o APT::Sandbox::User=root download busybox-static:arm64 && dpkg-deb -x busybox-static_*_arm64.deb first &&
    cp first/bin/busybox busybox && rm -rf first busybox-static_*_arm64.deb) >"$folder/busybox.log" 2>&1 ||
    skip "busybox-static:arm64 cannot be fetched: $folder/busybox.log"
}

# make_first_files "MODULE OPTION..."...: $folder/first.cpio, whose process loads the modules, finds the disk and starts
# systemd.
make_first_files() {
  local first=$folder/first module options file
  rm -rf "$first"
  mkdir -p "$first"/{bin,dev,disk,modules}
  cp "$folder/busybox" "$first/bin/busybox"
  for module in virtio_pci virtio_blk virtio-rng ext4 "$@"; do
    read -r module options <<<"$module"
    /sbin/modprobe -d "$kernel/root" -S "$(cat "$kernel/version")" --show-depends "$module" |
      sed -n 's/^insmod \(\S*\).*/\1/p' | sed "\$s/\$/ $options/"
  done | awk '!seen[$1]++' | while read -r file options; do
    cp "$file" "$first/modules/"
    echo "$(basename "$file") $options"
  done >"$first/modules/list"
  cat >"$first/init" <<'END'
#!/bin/busybox sh
b=/bin/busybox
$b mount -t devtmpfs devtmpfs /dev
while read -r module options; do $b insmod "/modules/$module" $options; done </modules/list
until [ -b /dev/vda ]; do $b sleep 0.1; done
$b mount -t ext4 /dev/vda /disk
exec $b switch_root /disk /lib/systemd/systemd
END
  chmod +x "$first/init"
  (cd "$first" && find . | cpio -o -H newc -R 0:0 --quiet) >"$folder/first.cpio"
}

# add_trial SCRIPT: into $root, a unit that runs the script, one that tells the board's time, and nothing that a boot does
# beside and that takes most of an emulated one.
add_trial() {
  install -m 755 "$1" "$root/usr/local/sbin/trial"
  cat >"$root/etc/systemd/system/trial.service" <<'END'
[Unit]
After=multi-user.target
[Service]
ExecStart=/usr/local/sbin/trial
StandardOutput=journal+console
[Install]
WantedBy=default.target
END
  cat >"$root/etc/systemd/system/beat.service" <<'END'
[Unit]
DefaultDependencies=no
[Service]
ExecStart=/bin/sh -c 'while read up idle </proc/uptime; do echo "BOARD $${up%%.*} s" >/dev/console; sleep 5; done'
[Install]
WantedBy=sysinit.target
END
  inside systemctl enable trial beat
  inside systemctl mask apt-daily.timer apt-daily-upgrade.timer dpkg-db-backup.timer e2scrub_all.timer e2scrub_reap.service \
    fstrim.timer systemd-tmpfiles-clean.timer systemd-udev-trigger.service systemd-hwdb-update.service \
    systemd-journal-catalog-update.service ldconfig.service systemd-pstore.service systemd-logind.service \
    getty@tty1.service
  touch "$root/etc/.updated" "$root/var/.updated"
}

# boot PART END TIME [OPTION OF QEMU...]: $disk, until the trial says END. The board's clock begins at TIME and is that of
# its instructions, so that on a busy host no timeout of systemd's expires, and the flight does not come to the end of its
# strip. While the board works, the function `beside` is called every second, if there is one.
boot() {
  local part=$1 end=$2 time=$3 log=$folder/$1.log began=$SECONDS up=0 why=
  shift 3
  rm -f "$log"
  qemu-system-aarch64 -M virt,gic-version=3 -cpu cortex-a57 -smp 1 -m 1024 -accel tcg,thread=single,tb-size=256 \
    -icount shift=0,sleep=on -rtc base=2027-06-01T"$time",clock=vm -display none -nodefaults -no-reboot -serial "file:$log" \
    -kernel "$kernel/vmlinuz" -initrd "$folder/first.cpio" -drive "file=$disk,if=none,id=disk,format=raw,cache=unsafe" \
    -device virtio-blk-pci,drive=disk -device virtio-rng-pci "$@" \
    -append "console=ttyAMA0 loglevel=4 panic=-1 mitigations=off systemd.show_status=no systemd.mask=serial-getty@ttyAMA0.service trial=$part" &
  local board=$!
  trap 'kill -9 '$board' 2>/dev/null || true' EXIT
  while kill -0 $board 2>/dev/null && ! grep -q "TRIAL \(cut\|FAILED\)" "$log" 2>/dev/null; do
    sleep 1
    ! declare -F beside >/dev/null || beside "$log"
    up=$(sed -n 's/.*BOARD \([0-9]*\) s.*/\1/p' "$log" 2>/dev/null | tail -1)
    [ "${up:-0}" -lt $board_s ] || { why="it does not end within $board_s s of its time"; break; }
    [ $((SECONDS - began)) -lt $host_s ] || { why="the host"; break; }
  done
  # Power is cut; after an ordered end there is nothing left to cut.
  kill -9 $board 2>/dev/null || true
  wait $board 2>/dev/null || true
  trap - EXIT
  grep -o "TRIAL .*" "$log" | sed "s/^TRIAL/$part:/" || true
  echo "part $part: ${up:-0} s of the board in $((SECONDS - began)) s"
  ! grep -q "TRIAL $end" "$log" || return 0
  tail -40 "$log"
  [ "$why" != "the host" ] || [ "${up:-0}" = 0 ] ||
    skip "the host is busy: it gave the board $up s of its time in $host_s s, so part $part has no result"
  fail "the board does not come to the end of part $part: ${why:-it ended}"
}
