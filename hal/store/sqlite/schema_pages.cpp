#include "hal/store/sqlite/schema_pages.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>

#include "fsw/base/big_endian.hpp"
#include "hal/store/sqlite/disk_file.hpp"
#include "hal/store/sqlite/page_checksum.hpp"

namespace ilp {
namespace {

using PageBytes = std::array<std::uint8_t, page_bytes>;

class PageFile {
 public:
  PageFile() = default;
  ~PageFile() {
    if (file_ >= 0) ::close(file_);
  }
  PageFile(const PageFile&) = delete;
  PageFile& operator=(const PageFile&) = delete;

  Status open(const char* path, int how) {
    ILP_TRY(open_disk_file(path, how, file_));
    struct stat state {};
    if (file_ >= 0 && ::fstat(file_, &state) != 0) return {StatusCode::io_error, errno};
    pages_ = static_cast<std::uint32_t>(state.st_size / static_cast<off_t>(page_bytes));
    return {};
  }
  [[nodiscard]] bool is_open() const { return file_ >= 0; }
  [[nodiscard]] std::uint32_t pages() const { return pages_; }
  /// Whether it is there and has its checksum, possibly after mending.
  Result<bool> read(std::uint32_t number, PageBytes& page) const {
    std::size_t got = 0;
    ILP_TRY(read_at(file_, page, place(number), got));
    return got == page.size() && check_page(number, page) != PageState::damaged;
  }
  Status write(std::uint32_t number, PageBytes& page) const {
    seal_page(number, page);
    return write_at(file_, page, place(number));
  }
  Status synchronise() const { return ::fsync(file_) == 0 ? Status{} : Status{StatusCode::io_error, errno}; }

 private:
  static std::int64_t place(std::uint32_t number) {
    return (static_cast<std::int64_t>(number) - 1) * static_cast<std::int64_t>(page_bytes);
  }
  int file_ = -1;
  std::uint32_t pages_ = 0;
};

std::uint32_t number_at(const PageBytes& page, std::size_t at, std::size_t bytes) {
  return static_cast<std::uint32_t>(load_big_endian(page.data() + at, bytes));
}

// https://www.sqlite.org/fileformat2.html: the table of the schema begins in the first page, after 100 octets.
constexpr std::size_t tree_begin = 100;
constexpr std::uint8_t interior_table = 5;
constexpr std::size_t cells_begin = tree_begin + 12;

/// Takes the size of the file from its first page and drops the list of free pages.
void fit_first_page(std::uint32_t pages, PageBytes& page) {
  store_big_endian(pages, 4, page.data() + 28);
  store_big_endian(0, 4, page.data() + 32);
  store_big_endian(0, 4, page.data() + 36);
}

/// Whether any page has the checksum that ours have.
Result<bool> has_ours(const PageFile& file) {
  PageBytes page;
  for (std::uint32_t number = 1; number <= file.pages(); ++number) {
    ILP_TAKE(const bool ours, file.read(number, page));
    if (ours) return true;
  }
  return false;
}

Status restore(const PageFile& damaged, const PageFile& fresh, std::uint32_t number) {
  PageBytes page;
  ILP_TAKE(const bool valid, damaged.read(number, page));
  if (valid) return {};
  ILP_TAKE(const bool known, fresh.read(number, page));
  if (!known) return {};
  if (number == 1) fit_first_page(damaged.pages(), page);
  return damaged.write(number, page);
}

}  // namespace

Status restore_schema_pages(const char* damaged, const char* fresh) {
  PageFile from;
  PageFile to;
  PageBytes first;
  ILP_TRY(from.open(fresh, O_RDONLY));
  ILP_TRY(to.open(damaged, O_RDWR));
  const Result<bool> valid = from.is_open() ? from.read(1, first) : false;
  ILP_TRY(valid.status());
  if (!valid.value()) return {StatusCode::io_error, ENOENT};
  const Result<bool> ours = to.is_open() ? has_ours(to) : false;
  if (!ours.ok() || !ours.value()) return ours.status();
  ILP_TRY(restore(to, from, 1));
  if (first[tree_begin] == interior_table) {
    const std::size_t cells = number_at(first, tree_begin + 3, 2);
    for (std::size_t c = 0; c < cells && cells_begin + 2 * c + 2 <= page_bytes; ++c) {
      const std::uint32_t cell = number_at(first, cells_begin + 2 * c, 2);
      if (cell + 4 <= page_bytes) ILP_TRY(restore(to, from, number_at(first, cell, 4)));
    }
    ILP_TRY(restore(to, from, number_at(first, tree_begin + 8, 4)));
  }
  return to.synchronise();
}

}  // namespace ilp
