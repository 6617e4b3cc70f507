#include "fsw/products/index_ranks.hpp"

namespace ilp {

std::size_t IndexRanks::bin_of(double index) {
  if (!(index > 0)) return 0;
  const auto bin = index < 1 ? static_cast<std::size_t>(index * static_cast<double>(bins)) : bins;
  return bin < bins ? bin : bins - 1;
}

std::uint32_t IndexRanks::images() const {
  std::uint32_t sum = 0;
  for (const std::uint32_t count : counts_) sum += count;
  return sum;
}

void IndexRanks::add(double index) {
  if (images() >= most_images) {
    for (std::uint32_t& count : counts_) count /= 2;
  }
  ++counts_[bin_of(index)];
}

double IndexRanks::rank(double index) const {
  constexpr double middle = 0.5;
  const std::uint32_t all = images();
  if (all < fewest_images) return middle;
  const std::size_t own = bin_of(index);
  std::uint32_t lower = 0;
  for (std::size_t bin = 0; bin < own; ++bin) lower += counts_[bin];
  return (lower + middle * counts_[own]) / all;
}

}  // namespace ilp
