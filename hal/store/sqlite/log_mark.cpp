#include "hal/store/sqlite/log_mark.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <initializer_list>

#include "cfg/limits.hpp"
#include "fsw/base/big_endian.hpp"
#include "fsw/base/crc.hpp"
#include "fsw/base/little_endian.hpp"
#include "fsw/base/text.hpp"
#include "hal/store/sqlite/disk_file.hpp"

namespace ilp {
namespace {

using MarkPath = FixedText<limits::max_path_bytes + 16>;
using Header = std::array<std::uint8_t, log_header_bytes>;
using Frame = std::array<std::uint8_t, frame_bytes>;

constexpr std::uint32_t log_magic = 0x377F0682;  ///< the lowest bit: words are read as big-endian numbers
constexpr std::uint32_t log_version = 3007000;

/// Salts (8), frames (8), CRC-32C of both.
constexpr std::size_t mark_bytes = 20;
// Flags in the highest bits of the frames.
constexpr std::uint64_t deferred_bit = std::uint64_t{1} << 63U;  ///< LogMark::defer_synchronisation()
constexpr std::uint64_t begun_bit = std::uint64_t{1} << 62U;     ///< LogMark::begin()

struct Mark {
  std::array<std::uint8_t, 8> salts{};
  std::int64_t frames = 0;  ///< 0: no length is known
  bool deferred = false;
  bool begun = false;
};

bool ends_with(const char* text, const char* end) {
  const std::size_t length = std::strlen(text);
  const std::size_t tail = std::strlen(end);
  return length >= tail && std::strcmp(text + length - tail, end) == 0;
}

/// The name of the mark from that of a log; empty if it is no log's name.
MarkPath mark_of(const char* log) {
  MarkPath path;
  if (log == nullptr || !ends_with(log, log_suffix)) return path;
  const std::size_t length = std::strlen(log) - std::strlen(log_suffix);
  for (std::size_t i = 0; i < length; ++i) path.add(log[i]);
  path.add(mark_suffix);
  return path;
}

std::uint32_t word_at(const std::uint8_t* from) {
  return static_cast<std::uint32_t>(load_big_endian(from, 4));
}

int flipped_bits(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b) {
  int bits = 0;
  for (std::size_t i = 0; i < a.size(); ++i) bits += std::popcount(static_cast<unsigned>(a[i] ^ b[i]));
  return bits;
}

/// A log on the disk, read without SQLite.
class LogFile {
 public:
  ~LogFile() {
    if (file_ >= 0) ::close(file_);
  }
  LogFile() = default;
  LogFile(const LogFile&) = delete;
  LogFile& operator=(const LogFile&) = delete;

  Status open(const char* path, bool writable) {
    MarkPath name;
    name.add(path).add(log_suffix);
    ILP_TRY(open_disk_file(name.c_str(), writable ? O_RDWR : O_RDONLY, file_));
    if (file_ < 0) return {};
    struct stat state {};
    if (::fstat(file_, &state) != 0) return {StatusCode::io_error, errno};
    std::size_t got = 0;
    ILP_TRY(read_at(file_, header_, 0, got));
    set_order();
    const bool begun =
        got == header_.size() && std::any_of(header_.begin(), header_.end(), [](std::uint8_t b) { return b != 0; });
    empty_ = !begun || state.st_size <= static_cast<off_t>(log_header_bytes);
    frames_ = begun ? (state.st_size - static_cast<off_t>(log_header_bytes)) / static_cast<off_t>(frame_bytes) : 0;
    return {};
  }

  /// It is not there, or has no frame.
  [[nodiscard]] bool empty() const { return empty_; }
  [[nodiscard]] Header& header() { return header_; }
  [[nodiscard]] bool big_endian() const { return big_endian_; }
  [[nodiscard]] std::int64_t frames() const { return frames_; }
  [[nodiscard]] std::span<const std::uint8_t> salts() const { return std::span(header_).subspan(16, 8); }
  [[nodiscard]] FrameSum header_sum() const { return add_to_frame_sum({}, std::span(header_).first(24), big_endian_); }
  [[nodiscard]] FrameSum stated_header_sum() const { return stated_frame_sum(std::span(header_).last<24>()); }
  [[nodiscard]] bool header_is_valid() const {
    return (word_at(header_.data()) & ~1U) == log_magic && word_at(header_.data() + 4) == log_version &&
           header_sum() == stated_header_sum();
  }
  [[nodiscard]] bool of_our_pages() const { return word_at(header_.data() + 8) == page_bytes; }
  void set_order() { big_endian_ = (header_[3] & 1U) != 0; }

  /// False at the end of the log.
  Result<bool> read(std::int64_t frame, Frame& to) const {
    std::size_t got = 0;
    ILP_TRY(read_at(file_, to, place(frame), got));
    return got == to.size();
  }
  Status write(std::int64_t frame, const Frame& from) const { return write_at(file_, from, place(frame)); }
  Status write_header() const { return write_at(file_, header_, 0); }
  Status synchronise() const { return ::fsync(file_) == 0 ? Status{} : Status{StatusCode::io_error, errno}; }

 private:
  static off_t place(std::int64_t frame) {
    return static_cast<off_t>(log_header_bytes) + static_cast<off_t>(frame) * static_cast<off_t>(frame_bytes);
  }
  int file_ = -1;
  std::int64_t frames_ = 0;
  bool empty_ = true;
  bool big_endian_ = false;
  Header header_{};
};

std::span<const std::uint8_t, frame_header_bytes> head(const Frame& frame) {
  return std::span(frame).first<frame_header_bytes>();
}
/// One bit of the salts may have flipped; the salts of other generations differ in half of their bits.
bool of_this_generation(const LogFile& log, const Frame& frame) {
  return flipped_bits(log.salts(), head(frame).subspan(8, 8)) <= 1;
}

struct Verdict {
  std::int64_t damaged = -1;   ///< first frame with a wrong checksum, -1 when there is none
  std::int64_t last_end = -1;  ///< latest frame that ends a transaction and is valid by itself
  int transactions = 0;        ///< that end at the damaged frame or after it
};

/// Compares every frame with the state that the previous frame declares, so that frames after a damaged one can be
/// judged too.
Status judge(const LogFile& log, Verdict& verdict) {
  FrameSum stated = log.stated_header_sum();
  FrameSum computed = log.header_sum();
  Frame frame;
  for (std::int64_t k = 0; k < log.frames(); ++k) {
    ILP_TAKE(const bool whole, log.read(k, frame));
    if (!whole) break;
    const bool own = of_this_generation(log, frame);
    const bool exact = own && flipped_bits(log.salts(), head(frame).subspan(8, 8)) == 0;
    const FrameSum follows = frame_sum(stated, frame, log.big_endian());
    const FrameSum otherwise = frame_sum(computed, frame, log.big_endian());
    stated = stated_frame_sum(head(frame));
    const bool valid = own && (follows == stated || otherwise == stated);
    if (verdict.damaged < 0 && !(exact && follows == stated)) verdict.damaged = k;
    const bool end = own && ends_transaction(head(frame));
    if (end && valid) verdict.last_end = k;
    if (verdict.damaged >= 0 && end && (valid || k == verdict.damaged)) ++verdict.transactions;
    computed = follows;
  }
  return {};
}

/// Nothing is known from a mark that was written in part.
Status read_mark(int file, Mark& mark) {
  mark = {};
  std::uint8_t bytes[mark_bytes];
  std::size_t got = 0;
  ILP_TRY(read_at(file, bytes, 0, got));
  if (got < sizeof(bytes) || load_little_endian<std::uint32_t>(bytes + 16) != crc32c({bytes, 16})) return {};
  std::copy_n(bytes, 8, mark.salts.begin());
  const auto frames = load_little_endian<std::uint64_t>(bytes + 8);
  mark.frames = static_cast<std::int64_t>(frames & ~(deferred_bit | begun_bit));
  mark.deferred = (frames & deferred_bit) != 0;
  mark.begun = (frames & begun_bit) != 0;
  return {};
}

Status read_mark(const char* path, Mark& mark) {
  MarkPath name;
  name.add(path).add(mark_suffix);
  int file = -1;
  ILP_TRY(open_disk_file(name.c_str(), O_RDONLY, file));
  if (file < 0) return {};
  const Status status = read_mark(file, mark);
  ::close(file);
  return status;
}

Status write_mark(int file, const Mark& mark) {
  std::uint8_t bytes[mark_bytes];
  std::copy(mark.salts.begin(), mark.salts.end(), bytes);
  const std::uint64_t flags = (mark.deferred ? deferred_bit : 0) | (mark.begun ? begun_bit : 0);
  store_little_endian(static_cast<std::uint64_t>(mark.frames) | flags, bytes + 8);
  store_little_endian(crc32c({bytes, 16}), bytes + 16);
  return write_at(file, bytes, 0);
}

/// The first salt counts the restarts of the log.
bool is_older(std::span<const std::uint8_t> salts, std::span<const std::uint8_t> than) {
  const std::uint32_t beginnings = word_at(than.data()) - word_at(salts.data());
  return beginnings != 0 && beginnings < 0x10000;
}

/// The bit of the header, or of the first 8 octets of a frame, whose flipping makes `fits` true.
template <typename Fits>
bool flip_until(std::span<std::uint8_t> bytes, Fits fits) {
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    const auto mask = static_cast<std::uint8_t>(1U << bit % 8);
    bytes[bit / 8] ^= mask;
    if (fits()) return true;
    bytes[bit / 8] ^= mask;
  }
  return false;
}

/// `log_damaged` if it cannot be mended.
Status mend_header(LogFile& log) {
  if (log.header_is_valid()) return {};
  // If several bits make its checksums right, the first frame decides which one.
  Frame frame;
  ILP_TAKE(const bool has_frame, log.read(0, frame));
  const auto valid = [&] {
    log.set_order();
    return log.header_is_valid() && log.of_our_pages() &&
           (!has_frame ||
            (flipped_bits(log.salts(), head(frame).subspan(8, 8)) == 0 &&
             frame_sum(log.stated_header_sum(), frame, log.big_endian()) == stated_frame_sum(head(frame))));
  };
  if (flip_until(log.header(), valid)) return log.write_header();
  log.set_order();
  return {StatusCode::log_damaged, 0, log.frames()};
}

/// Sets the last 8 octets of the page, which nothing reads, so that the frame's stated checksums become right.
void fit_to_checksum(FrameSum before, bool big_endian, Frame& frame) {
  const FrameSum stated = stated_frame_sum(head(frame));
  FrameSum sum = add_to_frame_sum(before, std::span(frame).first(8), big_endian);
  const auto page = std::span(frame).subspan(frame_header_bytes);
  sum = add_to_frame_sum(sum, page.first(page_bytes - page_checksum_bytes), big_endian);
  const std::uint32_t words[2] = {stated.first - sum.first - sum.second, stated.second - sum.second - stated.first};
  std::uint8_t* to = page.data() + page_bytes - page_checksum_bytes;
  for (const std::uint32_t word : words) {
    if (big_endian) {
      store_big_endian(word, 4, to);
    } else {
      store_little_endian(word, to);
    }
    to += 4;
  }
}

/// Counts the bits of the page whose flipping gives the frame its stated checksums; there may be several among the
/// higher bits of a word. If there is exactly one, it is flipped.
std::size_t mend_page(FrameSum before, bool big_endian, Frame& frame) {
  const FrameSum stated = stated_frame_sum(head(frame));
  const FrameSum is = frame_sum(before, frame, big_endian);
  const std::uint32_t first = stated.first - is.first;
  const std::uint32_t second = stated.second - is.second;
  const auto page = std::span(frame).subspan(frame_header_bytes);
  // The effect of an increment of one word on the checksums, from the last pair of words backwards.
  FrameSum even{1, 1};
  FrameSum odd{0, 1};
  std::size_t found = 0;
  std::size_t found_byte = 0;
  std::uint8_t found_mask = 0;
  for (std::size_t pair = page_bytes / 8; pair-- > 0;) {
    for (std::size_t word = 0; word < 2; ++word) {
      const FrameSum& effect = word == 0 ? even : odd;
      for (unsigned bit = 0; bit < 32; ++bit) {
        const std::size_t byte = 8 * pair + 4 * word + (big_endian ? 3 - bit / 8 : bit / 8);
        const auto mask = static_cast<std::uint8_t>(1U << bit % 8);
        const std::uint32_t change = (page[byte] & mask) != 0 ? 0U - (1U << bit) : 1U << bit;
        if (change * effect.first != first || change * effect.second != second) continue;
        ++found;
        found_byte = byte;
        found_mask = mask;
      }
    }
    for (FrameSum* const effect : {&even, &odd}) {
      effect->first += effect->second;
      effect->second += effect->first;
    }
  }
  if (found == 1) page[found_byte] ^= found_mask;
  return found;
}

void state_sum(FrameSum sum, Frame& frame) {
  store_big_endian(sum.first, 4, frame.data() + 16);
  store_big_endian(sum.second, 4, frame.data() + 20);
}

/// Returns false if the flipped bit is not certain; then only the salts of the frame have changed. `next_fits`: the
/// next frame continues from this one's real checksums, not from its stated ones.
[[gnu::noinline]] bool mend_frame(const LogFile& log, FrameSum before, bool next_fits, std::uint32_t max_page,
                                  Frame& frame) {
  std::copy(log.salts().begin(), log.salts().end(), frame.begin() + 8);
  const FrameSum sum = frame_sum(before, frame, log.big_endian());
  if (sum == stated_frame_sum(head(frame))) return true;
  Frame by_head = frame;
  const auto fits = [&] {
    const std::uint32_t page = word_at(by_head.data());
    return page > 0 && page <= max_page &&
           frame_sum(before, by_head, log.big_endian()) == stated_frame_sum(head(by_head));
  };
  Frame by_page = frame;
  const std::size_t in_page = mend_page(before, log.big_endian(), by_page);
  const bool in_head = flip_until(std::span(by_head).first(8), fits);
  const FrameSum stated = stated_frame_sum(head(frame));
  const bool in_sum = std::popcount(sum.first ^ stated.first) + std::popcount(sum.second ^ stated.second) == 1;
  if (next_fits || (in_sum && in_page == 0 && !in_head)) {
    state_sum(sum, frame);
    return true;
  }
  if (in_page + (in_head ? 1 : 0) != 1) return false;
  frame = in_head ? by_head : by_page;
  return true;
}

/// Walks through the frames of the latest transactions and restores their stated content.
Status walk_log(const char* path, bool only_mend) {
  LogFile log;
  ILP_TRY(log.open(path, true));
  if (log.empty()) return {StatusCode::log_damaged, 0, log.frames()};
  ILP_TRY(mend_header(log));
  if (!log.of_our_pages()) return {};
  Mark mark;
  Verdict verdict;
  ILP_TRY(read_mark(path, mark));
  ILP_TRY(judge(log, verdict));
  const bool marked = flipped_bits(log.salts(), mark.salts) == 0;
  const std::int64_t end = std::min(log.frames(), std::max(marked ? mark.frames : 0, verdict.last_end + 1));
  FrameSum before = log.stated_header_sum();
  Frame frame;
  Frame next;
  std::uint32_t max_page = 0;
  if (end > 0) {
    ILP_TAKE(const bool whole, log.read(end - 1, frame));
    if (whole) max_page = word_at(frame.data() + 4);
  }
  for (std::int64_t k = 0; k < end; ++k) {
    ILP_TAKE(const bool whole, log.read(k, frame));
    if (!whole) break;
    const FrameSum sum = frame_sum(before, frame, log.big_endian());
    const bool own = flipped_bits(log.salts(), head(frame).subspan(8, 8)) == 0;
    if (!own || sum != stated_frame_sum(head(frame))) {
      bool next_fits = false;
      if (k + 1 < end) {
        ILP_TAKE(const bool whole_next, log.read(k + 1, next));
        next_fits = whole_next && frame_sum(sum, next, log.big_endian()) == stated_frame_sum(head(next));
      }
      if (!mend_frame(log, before, next_fits, max_page, frame)) {
        if (only_mend) return {StatusCode::log_damaged, k, end};
        fit_to_checksum(before, log.big_endian(), frame);
      }
      ILP_TRY(log.write(k, frame));
    }
    before = stated_frame_sum(head(frame));
  }
  return log.synchronise();
}

}  // namespace

bool LogMark::open(const char* log) {
  const MarkPath path = mark_of(log);
  if (path.size() == 0 || path.overflow()) return true;
  const Status status = open_disk_file(path.c_str(), O_RDWR | O_CREAT, file_);
  // A disk without room for it has none that could be wrong.
  return status.ok() || status.a == ENOSPC;
}

void LogMark::close() {
  if (file_ >= 0) ::close(file_);
  file_ = -1;
}

void LogMark::begin(std::span<const std::uint8_t, 8> salts) {
  std::copy(salts.begin(), salts.end(), salts_);
  frames_ = 0;
  if (file_ < 0) return;
  Mark mark;
  std::copy_n(salts_, 8, mark.salts.begin());
  mark.deferred = deferred_;
  mark.begun = true;
  static_cast<void>(write_mark(file_, mark));
}

bool LogMark::lower(std::span<const std::uint8_t, 8> salts, std::int64_t frames) {
  if (std::equal(salts.begin(), salts.end(), salts_)) frames_ = std::min(frames_, frames);
  if (file_ < 0) return true;
  Mark mark;
  if (!read_mark(file_, mark).ok()) return false;
  if (mark.frames <= frames || !std::equal(salts.begin(), salts.end(), mark.salts.begin())) return true;
  mark.frames = frames;
  return write_mark(file_, mark).ok() && ::fdatasync(file_) == 0;
}

std::int64_t LogMark::frames_of(std::span<const std::uint8_t, 8> salts) const {
  return std::equal(salts.begin(), salts.end(), salts_) ? frames_ : 0;
}

void LogMark::write(std::span<const std::uint8_t, 8> salts, std::int64_t frames) {
  if (frames <= frames_of(salts)) return;
  std::copy(salts.begin(), salts.end(), salts_);
  frames_ = frames;
  if (file_ < 0) return;
  Mark mark;
  std::copy_n(salts_, 8, mark.salts.begin());
  mark.frames = frames_;
  mark.deferred = deferred_;
  static_cast<void>(write_mark(file_, mark));
}

bool LogMark::defer_synchronisation() {
  if (file_ < 0) return false;
  deferred_ = true;
  Mark mark;
  if (!read_mark(file_, mark).ok()) return false;
  if (mark.deferred) return true;
  mark.deferred = true;
  return write_mark(file_, mark).ok() && ::fdatasync(file_) == 0;
}

bool remove_log_mark(const char* log) {
  const MarkPath path = mark_of(log);
  return path.size() == 0 || path.overflow() || ::unlink(path.c_str()) == 0 || errno == ENOENT;
}

Status check_log(const char* path) {
  Mark mark;
  LogFile log;
  ILP_TRY(read_mark(path, mark));
  ILP_TRY(log.open(path, false));
  if (log.empty()) return mark.frames == 0 ? Status{} : Status{StatusCode::log_damaged, 0, mark.frames};
  // A log that is started over has been copied into the database, and its header may have been written in part.
  if (!log.header_is_valid()) return mark.begun ? Status{} : Status{StatusCode::log_damaged, 0, mark.frames};
  if (!log.of_our_pages()) return {};
  if (mark.frames > 0 && is_older(log.salts(), mark.salts)) return {StatusCode::log_damaged, 0, mark.frames};
  const bool marked = flipped_bits(log.salts(), mark.salts) == 0;
  const std::int64_t written = marked ? mark.frames : 0;
  Verdict verdict;
  ILP_TRY(judge(log, verdict));
  if (verdict.damaged < 0)
    return log.frames() >= written ? Status{} : Status{StatusCode::log_damaged, log.frames(), written};
  // A power cut may have interrupted the last transaction, or any that was not synchronised, unless it is known to be
  // complete.
  const bool lost = verdict.damaged < written || (verdict.transactions > 1 && !mark.deferred);
  return lost ? Status{StatusCode::log_damaged, verdict.damaged, std::max(written, verdict.last_end + 1)} : Status{};
}

Status mend_log(const char* path) {
  ILP_TRY(walk_log(path, true));
  return check_log(path);
}

Status bridge_log(const char* path) {
  return walk_log(path, false);
}

}  // namespace ilp
