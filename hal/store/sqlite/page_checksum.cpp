#include "hal/store/sqlite/page_checksum.hpp"

#include <bit>

#include "fsw/base/big_endian.hpp"
#include "fsw/base/crc.hpp"
#include "fsw/base/little_endian.hpp"

namespace ilp {
namespace {

constexpr std::size_t content_bytes = page_bytes - page_checksum_bytes;

struct PageSum {
  std::uint32_t crc = 0, sum = 0;
  bool operator==(const PageSum&) const = default;
};

PageSum sum_of(std::uint32_t number, Page page) {
  std::uint8_t name[4];
  store_little_endian(number, name);
  PageSum result{crc32c(page.first<content_bytes>(), crc32c(name)), number};
  for (std::size_t i = 0; i < content_bytes; i += 4) {
    result.sum += load_little_endian<std::uint32_t>(page.data() + i);
  }
  return result;
}

PageSum stated(Page page) {
  return {load_little_endian<std::uint32_t>(page.data() + content_bytes),
          load_little_endian<std::uint32_t>(page.data() + content_bytes + 4)};
}

std::uint32_t big_endian_word(const std::uint8_t* from) {
  return static_cast<std::uint32_t>(load_big_endian(from, 4));
}

}  // namespace

void seal_page(std::uint32_t number, Page page) {
  const PageSum sum = sum_of(number, page);
  store_little_endian(sum.crc, page.data() + content_bytes);
  store_little_endian(sum.sum, page.data() + content_bytes + 4);
}

PageState check_page(std::uint32_t number, Page page) {
  const PageSum should = stated(page);
  const PageSum is = sum_of(number, page);
  if (is == should) return PageState::valid;
  // The flipped bit may be in one of the checksums.
  const bool only_crc = is.sum == should.sum && std::has_single_bit(is.crc ^ should.crc);
  const bool only_sum = is.crc == should.crc && std::has_single_bit(is.sum ^ should.sum);
  if (only_crc || only_sum) return PageState::mended;
  const std::size_t bit = crc32c_flipped_bit(content_bytes, is.crc ^ should.crc);
  if (bit == 8 * content_bytes) return PageState::damaged;
  const auto mask = static_cast<std::uint8_t>(1U << bit % 8);
  page[bit / 8] ^= mask;
  if (sum_of(number, page) == should) return PageState::mended;
  page[bit / 8] ^= mask;
  return PageState::damaged;
}

FrameSum add_to_frame_sum(FrameSum sum, std::span<const std::uint8_t> bytes, bool big_endian) {
  for (std::size_t i = 0; i + 8 <= bytes.size(); i += 8) {
    const std::uint8_t* const at = bytes.data() + i;
    sum.first += (big_endian ? big_endian_word(at) : load_little_endian<std::uint32_t>(at)) + sum.second;
    sum.second += (big_endian ? big_endian_word(at + 4) : load_little_endian<std::uint32_t>(at + 4)) + sum.first;
  }
  return sum;
}

FrameSum frame_sum(FrameSum before, std::span<const std::uint8_t, frame_bytes> frame, bool big_endian) {
  const FrameSum head = add_to_frame_sum(before, frame.first<8>(), big_endian);
  return add_to_frame_sum(head, frame.subspan<frame_header_bytes>(), big_endian);
}

FrameSum stated_frame_sum(std::span<const std::uint8_t, frame_header_bytes> header) {
  return {big_endian_word(header.data() + 16), big_endian_word(header.data() + 20)};
}

bool ends_transaction(std::span<const std::uint8_t, frame_header_bytes> header) {
  return big_endian_word(header.data() + 4) != 0;
}

}  // namespace ilp
