#include "fsw/vision/codec/coding_passes.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>

#include "fsw/base/vector_width.hpp"

namespace ilp {
namespace {

constexpr std::int32_t most_rows = 64;
constexpr std::int32_t stripe_rows = 4;

/// One bit for each coefficient of a row.
using RowBits = std::uint64_t;
/// The rows of a block between two empty ones.
using BlockBits = std::array<RowBits, most_rows + 2>;

std::uint32_t magnitude_of(std::int32_t value) {
  const auto sign = static_cast<std::uint32_t>(value >> 31);
  return (static_cast<std::uint32_t>(value) ^ sign) - sign;
}

constexpr std::int32_t half_row = 32;
constexpr auto bit_of = [] {
  std::array<std::uint32_t, half_row> bits{};
  for (std::size_t i = 0; i < bits.size(); ++i) bits[i] = std::uint32_t{1} << i;
  return bits;
}();

/// Bits of the coefficients that have a plane from `plane` on.
RowBits bits_from(const std::int32_t* row, std::int32_t width, int plane) {
  RowBits all = 0;
  for (std::int32_t begin = 0; begin < width; begin += half_row) {
    std::uint32_t bits = 0;
    const auto bit = [&](std::int32_t i) {
      const bool set = (magnitude_of(row[begin + i]) >> static_cast<unsigned>(plane)) != 0;
      bits |= set ? bit_of[static_cast<std::size_t>(i)] : 0U;
    };
    if (width - begin >= half_row) {
      for (std::int32_t i = 0; i < half_row; ++i) bit(i);
    } else {
      for (std::int32_t i = 0; i < width - begin; ++i) bit(i);
    }
    all |= RowBits{bits} << static_cast<unsigned>(begin);
  }
  return all;
}

/// Whether a bit at x or beside it is set.
bool any_near(RowBits bits, int x) {
  constexpr RowBits three = 7;
  return ((x == 0 ? bits << 1U : bits >> static_cast<unsigned>(x - 1)) & three) != 0;
}

/// The significance propagation pass (D.3.1): those of `fresh` that it finds, that is, those with a significant
/// neighbour when their turn comes. `significant` has those from before the pass, and gets the found ones.
void propagate(const BlockBits& fresh, std::int32_t height, BlockBits& significant, BlockBits& found) {
  for (std::int32_t top = 0; top < height; top += stripe_rows) {
    const auto first = static_cast<std::size_t>(top) + 1;
    const std::size_t last = first + static_cast<std::size_t>(std::min(stripe_rows, height - top));
    RowBits columns = 0;
    for (std::size_t y = first; y < last; ++y) columns |= fresh[y];
    for (; columns != 0; columns &= columns - 1) {
      const int x = std::countr_zero(columns);
      const RowBits here = RowBits{1} << static_cast<unsigned>(x);
      for (std::size_t y = first; y < last; ++y) {
        if ((fresh[y] & here) == 0) continue;
        if (!any_near(significant[y - 1] | significant[y] | significant[y + 1], x)) continue;
        significant[y] |= here;
        found[y] |= here;
      }
    }
  }
}

/// The coefficients with a plane from `significant_plane` on, known down to `plane`.
void decode_row(const std::int32_t* __restrict row, std::ptrdiff_t width, int significant_plane, int plane,
                const KnownPasses& known, std::int32_t* __restrict decoded) {
  // Magnitudes have one more bit, so that half of the lowest plane is a whole number.
  const auto cut = static_cast<unsigned>(plane), lowest = static_cast<unsigned>(plane + known.dropped);
  const auto significant = std::uint32_t{1} << static_cast<unsigned>(significant_plane);
  const auto shift = static_cast<unsigned>(known.shift);
  const std::uint32_t region = std::uint32_t{1} << shift;
  for (std::ptrdiff_t x = 0; x < width; ++x) {
    const std::int32_t value = row[x];
    const std::uint32_t magnitude = magnitude_of(value);
    const std::uint32_t halves = ((magnitude >> cut << 1U) | 1U) << lowest;
    const std::uint32_t shifted = halves >= region ? halves >> shift : halves;
    const std::uint32_t whole = magnitude >= significant ? shifted >> 1U : 0U;
    const auto sign = static_cast<std::uint32_t>(value >> 31);
    decoded[x] = static_cast<std::int32_t>((whole ^ sign) - sign);
  }
}

/// Gives those of a row that were found significant in the last pass their values, in columns from x on.
void decode_found(const std::int32_t* row, RowBits found, std::int32_t x, std::int32_t width, int plane,
                  const KnownPasses& known, std::int32_t* decoded) {
  for (; found != 0; found &= found - 1) {
    const std::int32_t column = std::countr_zero(found);
    if (column < x || column >= x + width) continue;
    decode_row(row + column, 1, plane, plane, known, decoded + (column - x));
  }
}

}  // namespace

void decode_passes(ImageView<const std::int32_t> block, const KnownPasses& known, std::int32_t x, std::int32_t y,
                   ImageView<std::int32_t> decoded) {
  if (known.passes == 0) {
    for (std::int32_t i = 0; i < decoded.height; ++i) std::fill_n(decoded.row(i), decoded.width, 0);
    return;
  }
  // The first plane has the cleanup pass only, the others have significance propagation, refinement and cleanup.
  const int complete_plane = known.planes - (known.passes + 2) / 3;
  const int more_passes = (known.passes - 1) % 3;
  const int plane = more_passes == 2 ? complete_plane - 1 : complete_plane;
  BlockBits found{};
  with_widest_vectors([&] {
    if (more_passes > 0) {
      BlockBits significant{}, fresh{};
      for (std::int32_t i = 0; i < block.height; ++i) {
        const auto row = static_cast<std::size_t>(i) + 1;
        significant[row] = bits_from(block.row(i), block.width, complete_plane);
        fresh[row] = bits_from(block.row(i), block.width, complete_plane - 1) & ~significant[row];
      }
      propagate(fresh, block.height, significant, found);
    }
    for (std::int32_t i = 0; i < decoded.height; ++i) {
      const std::int32_t* const row = block.row(y + i);
      decode_row(row + x, decoded.width, complete_plane, plane, known, decoded.row(i));
      decode_found(row, found[static_cast<std::size_t>(y + i) + 1], x, decoded.width, complete_plane - 1, known,
                   decoded.row(i));
    }
  });
}

}  // namespace ilp
