#include "sim/ground/compare/height_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ilp::compare {
namespace {

constexpr float missing_height = std::numeric_limits<float>::quiet_NaN();
constexpr std::size_t most_blocks = 64;

}  // namespace

void HeightModel::reduce(std::int32_t factor) {
  factor = std::clamp(factor, 1, std::min(columns(), rows()) / 2);
  if (factor == factor_) return;
  factor_ = factor;
  blocks_.clear();
  where_.clear();
}

HeightModel::Block HeightModel::read_block(std::int32_t column, std::int32_t row) {
  const std::int32_t x = column * block_side, y = row * block_side;
  return band_.read(x * factor_, y * factor_, std::min(block_side, reduced_columns() - x),
                    std::min(block_side, reduced_rows() - y), factor_);
}

const HeightModel::Block& HeightModel::block(std::int32_t column, std::int32_t row) {
  const std::int64_t key = (std::int64_t{row} << 32) + column;
  if (!blocks_.empty() && blocks_.front().first == key) return blocks_.front().second;
  const auto known = where_.find(key);
  if (known != where_.end()) {
    blocks_.splice(blocks_.begin(), blocks_, known->second);
    return blocks_.front().second;
  }
  if (blocks_.size() >= most_blocks) {
    where_.erase(blocks_.back().first);
    blocks_.pop_back();
  }
  blocks_.emplace_front(key, read_block(column, row));
  where_[key] = blocks_.begin();
  return blocks_.front().second;
}

float HeightModel::cell(std::int32_t column, std::int32_t row) {
  return block(column / block_side, row / block_side).at(column % block_side, row % block_side);
}

bool HeightModel::contains(double column, double row) const {
  const double i = (column + 0.5) / factor_ - 0.5, j = (row + 0.5) / factor_ - 0.5;
  return i >= 0 && j >= 0 && i <= reduced_columns() - 1 && j <= reduced_rows() - 1;
}

double HeightModel::height_at(double column, double row) {
  if (!contains(column, row)) return missing_height;
  const double x = (column + 0.5) / factor_ - 0.5, y = (row + 0.5) / factor_ - 0.5;
  const std::int32_t i = std::min(static_cast<std::int32_t>(x), reduced_columns() - 2);
  const std::int32_t j = std::min(static_cast<std::int32_t>(y), reduced_rows() - 2);
  const double u = x - i, v = y - j;
  return (1 - v) * ((1 - u) * double{cell(i, j)} + u * double{cell(i + 1, j)}) +
         v * ((1 - u) * double{cell(i, j + 1)} + u * double{cell(i + 1, j + 1)});
}

HeightModel::Sample HeightModel::at(double column, double row) {
  // Over two cells, so that noise of the model's own weighs less.
  const double step = factor_;
  Sample sample;
  sample.height = height_at(column, row);
  if (!std::isfinite(sample.height)) return sample;
  sample.per_column = (height_at(column + step, row) - height_at(column - step, row)) / (2 * step);
  sample.per_row = (height_at(column, row + step) - height_at(column, row - step)) / (2 * step);
  return sample;
}

}  // namespace ilp::compare
