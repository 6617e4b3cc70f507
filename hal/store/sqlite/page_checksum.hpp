// Checksums of a database's pages, and of the frames of its write-ahead log, and how one flipped bit is mended.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace ilp {

inline constexpr std::size_t page_bytes = 4096;
/// At the end of each page, where SQLite leaves them alone: CRC-32C and the sum of the 32-bit words.
inline constexpr std::size_t page_checksum_bytes = 8;

using Page = std::span<std::uint8_t, page_bytes>;

/// `number` counts from 1 and belongs to what is checked: a page in another's place is no page.
void seal_page(std::uint32_t number, Page page);

enum class PageState : std::uint8_t { sound, mended, damaged };
/// One flipped bit is mended in `page`: the CRC says which, and the sum has to agree.
PageState check_page(std::uint32_t number, Page page);

/// A frame of the log is a header of 24 octets and a page (https://www.sqlite.org/fileformat2.html, "The Write-Ahead
/// Log"): page number, size of the database where the frame ends a transaction, two salts, two checksums that go on
/// from those of the frame before.
inline constexpr std::size_t log_header_bytes = 32;
inline constexpr std::size_t frame_header_bytes = 24;
inline constexpr std::size_t frame_bytes = frame_header_bytes + page_bytes;

struct FrameSum {
  std::uint32_t first = 0, second = 0;
  bool operator==(const FrameSum&) const = default;
};

/// `bytes`: a multiple of 8. `big_endian`: how the log's words are read.
[[nodiscard]] FrameSum add_to_frame_sum(FrameSum sum, std::span<const std::uint8_t> bytes, bool big_endian);
/// Of the first 8 octets of the header and the page.
[[nodiscard]] FrameSum frame_sum(FrameSum before, std::span<const std::uint8_t, frame_bytes> frame, bool big_endian);
/// As the header states it; the header's numbers are big-endian always.
[[nodiscard]] FrameSum stated_frame_sum(std::span<const std::uint8_t, frame_header_bytes> header);

}  // namespace ilp
