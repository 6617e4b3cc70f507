"""The log that QEMU's blklogwrites keeps of a disk, and the disk as a power cut would have left it.

A disk keeps what it was told to flush, and what was written with force unit access. Of the writes since the last flush
any part may have reached it, whatever their order, and one may have been torn between two sectors."""
import os
import shutil
import struct

MAGIC = 0x6A736677736872
FLUSH, FORCED, DISCARD, MARK = 1, 2, 4, 8
SECTOR = 512
KEPT = 0.5  # of the writes since the last flush
TORN = 0.3  # of those kept


class WriteLog:
    """`entries` has (first sector, sectors, flags, place of the data in the log), in the order of completion."""

    def __init__(self, path):
        self._file = open(path, "rb")
        magic, version, count, self.sector = struct.unpack("<QQQI", self._file.read(28))
        if magic != MAGIC or version != 1:
            raise ValueError(f"{path} is no log of writes")
        self.entries = []
        size = os.path.getsize(path)
        place = self.sector
        for _ in range(count):
            self._file.seek(place)
            first, sectors, flags, extra = struct.unpack("<QQQQ", self._file.read(32))
            place += self.sector
            self.entries.append((first, sectors, flags, place))
            if not flags & (DISCARD | MARK):
                place += sectors * self.sector
            if flags & MARK:
                place += (extra + self.sector - 1) // self.sector * self.sector
            if place > size:
                self.entries.pop()
                break
        self._flushed = [0]
        for i, entry in enumerate(self.entries):
            self._flushed.append(i if entry[2] & FLUSH else self._flushed[-1])

    def data(self, entry):
        self._file.seek(entry[3])
        return self._file.read(entry[1] * self.sector)

    def writes(self, begin, end):
        return [entry for entry in self.entries[begin:end] if entry[1] and not entry[2] & (DISCARD | MARK)]

    def last_flush(self, end):
        """Entries before this one are on the disk for good when the power goes before entry `end`."""
        return self._flushed[end]

    def count(self):
        flushes = sum(1 for entry in self.entries if entry[2] & FLUSH)
        return len(self.writes(0, len(self.entries))), flushes


class CutDisk:
    """Images of the disk after cuts, which have to be asked for in ascending order."""

    def __init__(self, log, base, work):
        self._log, self._work, self._durable = log, work, 0
        shutil.copyfile(base, work)

    def _apply(self, disk, entry, data):
        disk.seek(entry[0] * self._log.sector)
        disk.write(data)

    def cut(self, end, torn, chance, image):
        """Writes `image`; returns how many writes were lost, in whole or in part."""
        flushed = self._log.last_flush(end)
        with open(self._work, "r+b") as disk:
            for entry in self._log.writes(self._durable, flushed):
                self._apply(disk, entry, self._log.data(entry))
        self._durable = max(self._durable, flushed)
        shutil.copyfile(self._work, image)
        lost = 0
        with open(image, "r+b") as disk:
            for entry in self._log.writes(flushed, end):
                data = self._log.data(entry)
                if not entry[2] & FORCED and chance.random() >= KEPT:
                    lost += 1
                    continue
                if torn and not entry[2] & FORCED and chance.random() < TORN:
                    data = data[:SECTOR * chance.randrange(len(data) // SECTOR + 1)]
                    lost += 1
                self._apply(disk, entry, data)
        return lost
