#include "hal/store/sqlite/schema_pages.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>

#include "hal/store/sqlite/page_checksum.hpp"

namespace ilp {
namespace {

using PageBytes = std::array<std::uint8_t, page_bytes>;

class PageFile {
 public:
  PageFile(const char* path, int how) : file_(::open(path, how | O_CLOEXEC)) {}
  ~PageFile() {
    if (file_ >= 0) ::close(file_);
  }
  PageFile(const PageFile&) = delete;
  PageFile& operator=(const PageFile&) = delete;

  [[nodiscard]] bool is_open() const { return file_ >= 0; }
  [[nodiscard]] std::uint32_t pages() const {
    struct stat state {};
    return ::fstat(file_, &state) == 0 ? static_cast<std::uint32_t>(state.st_size / static_cast<off_t>(page_bytes)) : 0;
  }
  /// Whether it was read and has its checksum, possibly after mending.
  bool read(std::uint32_t number, PageBytes& page) const {
    return ::pread(file_, page.data(), page.size(), place(number)) == static_cast<ssize_t>(page.size()) &&
           check_page(number, page) != PageState::damaged;
  }
  bool write(std::uint32_t number, PageBytes& page) const {
    seal_page(number, page);
    return ::pwrite(file_, page.data(), page.size(), place(number)) == static_cast<ssize_t>(page.size());
  }
  bool synchronise() const { return ::fsync(file_) == 0; }

 private:
  static off_t place(std::uint32_t number) { return static_cast<off_t>(number - 1) * static_cast<off_t>(page_bytes); }
  int file_;
};

std::uint32_t number_at(const PageBytes& page, std::size_t at, int bytes) {
  std::uint32_t value = 0;
  for (int i = 0; i < bytes; ++i) value = value << 8U | page[at + static_cast<std::size_t>(i)];
  return value;
}

void put_number(std::uint32_t value, PageBytes& page, std::size_t at) {
  for (std::size_t i = 0; i < 4; ++i) page[at + i] = static_cast<std::uint8_t>(value >> (24U - 8U * i));
}

// https://www.sqlite.org/fileformat2.html: the table of the schema begins in the first page, after 100 octets.
constexpr std::size_t tree_begin = 100;
constexpr std::uint8_t interior_table = 5;
constexpr std::size_t cells_begin = tree_begin + 12;

/// Takes the size of the file from its first page and drops the list of free pages.
void fit_first_page(std::uint32_t pages, PageBytes& page) {
  put_number(pages, page, 28);
  put_number(0, page, 32);
  put_number(0, page, 36);
}

bool is_ours(const PageFile& file, std::uint32_t pages) {
  PageBytes page;
  for (std::uint32_t number = 1; number <= pages; ++number) {
    if (file.read(number, page)) return true;
  }
  return false;
}

bool restore(const PageFile& damaged, const PageFile& fresh, std::uint32_t number) {
  PageBytes page;
  if (damaged.read(number, page)) return true;
  if (!fresh.read(number, page)) return true;
  if (number == 1) fit_first_page(damaged.pages(), page);
  return damaged.write(number, page);
}

}  // namespace

Status restore_schema_pages(const char* damaged, const char* fresh) {
  const PageFile from(fresh, O_RDONLY);
  const PageFile to(damaged, O_RDWR);
  PageBytes first;
  if (!from.is_open() || !from.read(1, first)) return {StatusCode::io_error, errno};
  if (!to.is_open() || !is_ours(to, to.pages())) return {};
  bool written = restore(to, from, 1);
  if (first[tree_begin] == interior_table) {
    const std::size_t cells = number_at(first, tree_begin + 3, 2);
    for (std::size_t c = 0; c < cells && cells_begin + 2 * c + 2 <= page_bytes; ++c) {
      const std::uint32_t cell = number_at(first, cells_begin + 2 * c, 2);
      if (cell + 4 <= page_bytes) written = restore(to, from, number_at(first, cell, 4)) && written;
    }
    written = restore(to, from, number_at(first, tree_begin + 8, 4)) && written;
  }
  return written && to.synchronise() ? Status{} : Status{StatusCode::io_error, errno};
}

}  // namespace ilp
