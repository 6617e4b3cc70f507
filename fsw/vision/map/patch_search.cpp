#include "fsw/vision/map/patch_search.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/word_lanes.hpp"

namespace ilp {
namespace {

using Sheet = MapChannels<max_map_sheet_side>;
using Window = MapChannels<max_map_window_side>;

constexpr std::int32_t least_direction2 = 25;  // mean square of directions in a patch with texture
constexpr std::int32_t least_deviation2 = 16;  // of its values
constexpr std::size_t patch_cells = std::size_t{max_map_patch_side} * max_map_patch_side;

/// Rows of zeros behind those that the lags need: rows of lags are computed four at a time.
void clear_beyond(std::int32_t rows, std::int32_t* out) {
  const auto used = static_cast<std::size_t>(rows) * map_reach_stride;
  const std::size_t all = static_cast<std::size_t>(map_reach_rows) * map_reach_stride;
  const std::size_t spare = static_cast<std::size_t>(map_rows_at_once) * map_reach_stride;
  std::fill_n(out + used, std::min(spare, all - used), 0);
}

/// Two words of 16 bits as one of 32.
std::int32_t pair_of(std::int32_t low, std::int32_t high) {
  return static_cast<std::int32_t>((static_cast<std::uint32_t>(low) & 0xFFFFU) | static_cast<std::uint32_t>(high)
                                                                                     << 16U);
}

/// What the lags need of the window: rows and columns of a rectangle.
struct Reach {
  std::int32_t column, row, columns, rows;
};

/// A patch as pairs of words, and what its correlation is divided by.
struct PatchPairs {
  std::array<std::int32_t, patch_cells> pair;
  std::int32_t rows = 0, row_step = 1;  ///< rows of pairs, and the distance of two of them in the window
  std::int32_t sum = 0;
  float energy = 0;

  /// Of the pair in a row of pairs of a patch with this side.
  [[nodiscard]] static std::size_t at(std::int32_t x, std::int32_t row, std::int32_t side) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(side) + static_cast<std::size_t>(x);
  }
};

std::int32_t value_or_mean(std::int16_t value) {
  return value == unknown_value ? 0 : value;
}

std::int32_t squared_length(const std::int8_t* direction) {
  return direction[0] * direction[0] + direction[1] * direction[1];
}

void take_directions(const Sheet& sheet, const MapPatch& patch, std::int32_t side, PatchPairs& pairs) {
  std::int64_t energy = 0;
  for (std::int32_t y = 0; y < side; ++y) {
    const std::int8_t* from = sheet.direction.data() + 2 * sheet.at(patch.column, patch.row + y);
    for (std::int32_t x = 0; x < side; ++x, from += 2) {
      pairs.pair[PatchPairs::at(x, y, side)] = pair_of(from[0], from[1]);
      energy += squared_length(from);
    }
  }
  pairs.rows = side;
  pairs.row_step = 1;
  pairs.energy = static_cast<float>(energy);
}

/// Values about their mean; two rows make one of pairs.
void take_values(const Sheet& sheet, const MapPatch& patch, std::int32_t side, PatchPairs& pairs) {
  std::int32_t sum = 0, count = 0;
  for (std::int32_t y = 0; y < side; ++y) {
    for (std::int32_t x = 0; x < side; ++x) {
      const std::int16_t value = sheet.value[sheet.at(patch.column + x, patch.row + y)];
      sum += value_or_mean(value);
      count += value != unknown_value ? 1 : 0;
    }
  }
  const std::int32_t mean = count > 0 ? sum / count : 0;
  const auto centred = [&](std::int32_t x, std::int32_t y) {
    const std::int16_t value = sheet.value[sheet.at(patch.column + x, patch.row + y)];
    return value == unknown_value ? 0 : value - mean;
  };
  std::int64_t energy = 0;
  pairs.sum = 0;
  for (std::int32_t y = 0; y < side; y += 2) {
    for (std::int32_t x = 0; x < side; ++x) {
      const std::int32_t a = centred(x, y), b = centred(x, y + 1);
      pairs.pair[PatchPairs::at(x, y / 2, side)] = pair_of(a, b);
      energy += std::int64_t{a} * a + std::int64_t{b} * b;
      pairs.sum += a + b;
    }
  }
  pairs.rows = side / 2;
  pairs.row_step = 2;
  pairs.energy = static_cast<float>(energy);
}

void reach_directions(const Window& window, const Reach& reach, std::int32_t* out) {
  clear_beyond(reach.rows, out);
  for (std::int32_t y = 0; y < reach.rows; ++y, out += map_reach_stride) {
    const std::int8_t* from = window.direction.data() + 2 * window.at(reach.column, reach.row + y);
    for (std::int32_t x = 0; x < reach.columns; ++x, from += 2) out[x] = pair_of(from[0], from[1]);
    std::fill(out + reach.columns, out + map_reach_stride, 0);
  }
}

void reach_values(const Window& window, const Reach& reach, std::int32_t* out) {
  clear_beyond(reach.rows, out);
  for (std::int32_t y = 0; y < reach.rows; ++y, out += map_reach_stride) {
    const std::int16_t* from = window.value.data() + window.at(reach.column, reach.row + y);
    const std::int16_t* next = y + 1 < reach.rows ? from + window.width : from;  // of the last row nothing is used
    for (std::int32_t x = 0; x < reach.columns; ++x) out[x] = pair_of(value_or_mean(from[x]), value_or_mean(next[x]));
    std::fill(out + reach.columns, out + map_reach_stride, 0);
  }
}

/// `count` vectors of lags of two rows, which are patch.row_step apart: what one row has loaded serves the other.
template <typename Width, int count>
void correlate_lags(const PatchPairs& patch, std::int32_t side, const std::int32_t* reach, std::int32_t* first_out,
                    std::int32_t* second_out) {
  using Lanes = WordLanes<Width>;
  using Words = typename Lanes::Words;
  using Sums = typename Lanes::Sums;
  Sums first[count] = {}, second[count] = {};
  const std::array<std::int32_t, max_map_patch_side> none{};
  for (std::int32_t y = 0; y <= patch.rows; ++y) {
    const std::int32_t* row = reach + static_cast<std::ptrdiff_t>(y) * patch.row_step * map_reach_stride;
    const std::int32_t* const here = y < patch.rows ? patch.pair.data() + PatchPairs::at(0, y, side) : none.data();
    const std::int32_t* const above = y > 0 ? patch.pair.data() + PatchPairs::at(0, y - 1, side) : none.data();
    for (std::int32_t x = 0; x < side; ++x) {
      const Sums same_here = Sums{} + here[x], same_above = Sums{} + above[x];
      const auto a = reinterpret_cast<Words>(same_here), b = reinterpret_cast<Words>(same_above);
      for (int k = 0; k < count; ++k) {
        Words ground;
        load_lanes(row + x + k * Lanes::sum_count, ground);
        Lanes::add_products(a, ground, first[k]);
        Lanes::add_products(b, ground, second[k]);
      }
    }
  }
  std::memcpy(first_out, first, sizeof first);
  std::memcpy(second_out, second, sizeof second);
}

using Products = std::array<std::array<std::int32_t, static_cast<std::size_t>(map_lag_stride)>, map_rows_at_once>;

/// Sums of products at every lag of four rows, and at some more.
template <typename Width>
void correlate_rows(const PatchPairs& patch, std::int32_t side, const std::int32_t* reach, std::int32_t columns,
                    Products& products) {
  constexpr std::int32_t lanes = WordLanes<Width>::sum_count;
  for (std::int32_t pair = 0; pair < 2; ++pair) {
    const std::int32_t row = patch.row_step == 1 ? 2 * pair : pair;
    const std::int32_t partner = row + patch.row_step;
    const std::int32_t* const from = reach + static_cast<std::ptrdiff_t>(row) * map_reach_stride;
    std::int32_t* const first = products[static_cast<std::size_t>(row)].data();
    std::int32_t* const second = products[static_cast<std::size_t>(partner)].data();
    std::int32_t lag = 0;
    for (; lag + 3 * lanes < columns; lag += 4 * lanes) {
      correlate_lags<Width, 4>(patch, side, from + lag, first + lag, second + lag);
    }
    const std::int32_t left = columns - lag;
    if (left > 2 * lanes) {
      correlate_lags<Width, 3>(patch, side, from + lag, first + lag, second + lag);
    } else if (left > lanes) {
      correlate_lags<Width, 2>(patch, side, from + lag, first + lag, second + lag);
    } else if (left > 0) {
      correlate_lags<Width, 1>(patch, side, from + lag, first + lag, second + lag);
    }
  }
}

using Columns = std::array<std::int32_t, static_cast<std::size_t>(map_reach_stride)>;

/// Sums over the window's cells behind a patch, for a row of lags.
struct Behind {
  Columns known_column{}, sum_column{}, energy_column{};  ///< of the patch's rows
  Columns known{}, sum{}, energy{};                       ///< of the patch, by lag

  template <bool values>
  void add_row(const Window& window, const Reach& reach, std::int32_t row, std::int32_t sign) {
    const std::size_t at = window.at(reach.column, reach.row + row);
    const std::int16_t* const value = window.value.data() + at;
    const std::int8_t* direction = window.direction.data() + 2 * at;
    for (std::int32_t x = 0; x < reach.columns; ++x, direction += 2) {
      const auto k = static_cast<std::size_t>(x);
      known_column[k] += value[x] != unknown_value ? sign : 0;
      if constexpr (values) {
        const std::int32_t v = value[x] == unknown_value ? 0 : value[x];
        sum_column[k] += sign * v;
        energy_column[k] += sign * v * v;
      } else {
        energy_column[k] += sign * squared_length(direction);
      }
    }
  }
  template <bool values>
  void slide(std::int32_t side, std::int32_t columns) {
    slide(known_column, side, columns, known);
    if constexpr (values) slide(sum_column, side, columns, sum);
    slide(energy_column, side, columns, energy);
  }

 private:
  static void slide(const Columns& from, std::int32_t side, std::int32_t columns, Columns& to) {
    std::int32_t total = 0;
    for (std::int32_t x = 0; x < side - 1; ++x) total += from[static_cast<std::size_t>(x)];
    for (std::int32_t x = 0; x < columns; ++x) {
      total += from[static_cast<std::size_t>(x + side - 1)];
      to[static_cast<std::size_t>(x)] = total;
      total -= from[static_cast<std::size_t>(x)];
    }
  }
};

/// Products to scores: replaces them, or adds to what stands in `scores`.
void score_directions(const PatchPairs& patch, const Behind& behind, std::int32_t columns, const std::int32_t* products,
                      std::int32_t* scores) {
  const float scale = static_cast<float>(map_score_one) / std::sqrt(patch.energy);
  for (std::int32_t x = 0; x < columns; ++x) {
    const float energy = static_cast<float>(behind.energy[static_cast<std::size_t>(x)]) + 1;
    scores[x] = static_cast<std::int32_t>(static_cast<float>(products[x]) * scale / std::sqrt(energy));
  }
}
void add_values(const PatchPairs& patch, const Behind& behind, const PatchSearch& how, std::int32_t columns,
                const std::int32_t* products, std::int32_t* scores) {
  const float scale = how.value_share * static_cast<float>(map_score_one) / std::sqrt(patch.energy);
  const auto damping = static_cast<float>(least_deviation2 * how.side * how.side);
  const auto rest = static_cast<float>(patch.sum);
  for (std::int32_t x = 0; x < columns; ++x) {
    const auto k = static_cast<std::size_t>(x);
    const auto sum = static_cast<float>(behind.sum[k]);
    const float mean = sum / static_cast<float>(std::max(behind.known[k], 1));
    const float energy = std::max(static_cast<float>(behind.energy[k]) - mean * sum, 0.0F) + damping;
    scores[x] += static_cast<std::int32_t>((static_cast<float>(products[x]) - rest * mean) * scale / std::sqrt(energy));
  }
}

template <typename Width, bool values>
void search(const PatchPairs& pairs, const PatchSearch& how, const LagRange& lags, const Reach& reach,
            MapRegistrationWorkspace& workspace) {
  const std::int32_t side = how.side;
  Behind behind;
  Products products;
  for (std::int32_t y = 0; y < side - 1; ++y) behind.add_row<values>(workspace.window, reach, y, 1);
  for (std::int32_t lag = 0; lag < lags.rows; ++lag) {
    const std::int32_t of_four = lag % map_rows_at_once;
    if (of_four == 0) {
      const std::int32_t* const from = workspace.reach.data() + static_cast<std::ptrdiff_t>(lag) * map_reach_stride;
      correlate_rows<Width>(pairs, side, from, lags.columns, products);
    }
    const std::int32_t* const row = products[static_cast<std::size_t>(of_four)].data();
    behind.add_row<values>(workspace.window, reach, lag + side - 1, 1);
    behind.slide<values>(side, lags.columns);
    std::int32_t* const scores = workspace.surface.data() + static_cast<std::ptrdiff_t>(lag) * map_lag_stride;
    if constexpr (values) {
      add_values(pairs, behind, how, lags.columns, row, scores);
    } else {
      score_directions(pairs, behind, lags.columns, row, scores);
    }
    for (std::int32_t x = 0; x < lags.columns; ++x) {
      if (2 * behind.known[static_cast<std::size_t>(x)] < side * side) scores[x] = unknown_score;
    }
    behind.add_row<values>(workspace.window, reach, lag, -1);
  }
}

}  // namespace

bool has_texture(const MapChannels<max_map_sheet_side>& sheet, const MapPatch& patch, const PatchSearch& search) {
  PatchPairs pairs;
  const auto cells = static_cast<float>(search.side * search.side);
  take_directions(sheet, patch, search.side, pairs);
  if (pairs.energy < least_direction2 * cells) return false;
  if (!(search.value_share > 0)) return true;
  take_values(sheet, patch, search.side, pairs);
  return pairs.energy >= least_deviation2 * cells;
}

void search_patch(const MapPatch& patch, const PatchSearch& how, const LagRange& lags,
                  MapRegistrationWorkspace& workspace) {
  const std::int32_t side = how.side;
  const Reach reach{patch.column + lags.first_column, patch.row + lags.first_row, lags.columns + side - 1,
                    lags.rows + side - 1};
  PatchPairs pairs;
  take_directions(workspace.sheet, patch, side, pairs);
  reach_directions(workspace.window, reach, workspace.reach.data());
  with_known_vectors([&]<typename Width>(Width) { search<Width, false>(pairs, how, lags, reach, workspace); });
  if (!(how.value_share > 0)) return;
  take_values(workspace.sheet, patch, side, pairs);
  reach_values(workspace.window, reach, workspace.reach.data());
  with_known_vectors([&]<typename Width>(Width) { search<Width, true>(pairs, how, lags, reach, workspace); });
}

}  // namespace ilp
