#include "fsw/storage/storage_victims.hpp"

#include "fsw/base/math.hpp"
#include "fsw/shared/valid_store.hpp"

namespace ilp {
namespace {

constexpr int products_per_look = 128;
constexpr double db_per_factor = 8.685889638065037;  // 20 / ln 10
constexpr double most_gain_db = 20;

double gain_db(const ProductRecord& product) {
  const std::size_t last = product.layers - 1U;
  const auto before = static_cast<double>(product.layer_quality[last - 1]);
  const auto after = static_cast<double>(product.layer_quality[last]);
  const bool depth = product.kind == ProductKind::depth;
  if (!(before > 0) || (depth && !(after >= 0)) || (!depth && !(after > 0))) return 1;
  double gain = after - before;
  if (depth) gain = after > 0 ? db_per_factor * det_log(before / after) : most_gain_db;
  // Exact images have infinite quality.
  if (!(gain < most_gain_db)) return most_gain_db;
  return gain > 0 ? gain : 0;
}

}  // namespace

bool last_layer_can_go(const ProductRecord& product) {
  return product.state == ProductState::stored && product.data.bytes != 0 && product.layers > 1 &&
         product.layers <= limits::max_quality_layers && product.layers > product.layers_sent;
}

bool product_can_go(const ProductRecord& product) {
  return product.state == ProductState::stored && product.data.bytes != 0 && product.layers_sent == 0;
}

double utility_of_last_layer(const ProductRecord& product) {
  const std::uint32_t before = product.layer_bytes[product.layers - 2U];
  const std::uint32_t bytes = product.data.bytes > before ? product.data.bytes - before : 1;
  return product.priority * gain_db(product) / static_cast<double>(bytes);
}

void VictimSearch::restart() {
  looked_at_id_ = 0;
  complete_ = false;
  any_layer_ = false;
  taken_ = 0;
  layers_.clear();
  products_.clear();
}

void VictimSearch::insert(const Victim& victim, Victims& victims) {
  if (victims.full()) {
    if (!(victim.utility < victims.back().utility)) return;
    victims.pop_back();
  }
  static_cast<void>(victims.push_back(victim));
  for (std::size_t i = victims.size() - 1; i > 0 && victims[i].utility < victims[i - 1].utility; --i) {
    const Victim other = victims[i - 1];
    victims[i - 1] = victims[i];
    victims[i] = other;
  }
}

Status VictimSearch::look(Reader<ProductRecord> store, std::int64_t through_id) {
  ProductRecord product;
  for (int looks = 0; looks < products_per_look; ++looks) {
    ILP_TAKE(const bool found, find_next_valid(store, looked_at_id_, product));
    complete_ = !found || product.id > through_id;
    if (complete_) return {};
    looked_at_id_ = product.id;
    if (last_layer_can_go(product)) {
      any_layer_ = true;
      insert({product.id, utility_of_last_layer(product)}, layers_);
    }
    if (product_can_go(product)) insert({product.id, product.priority}, products_);
  }
  return {};
}

bool VictimSearch::take(Victim& victim) {
  const Victims& victims = of_whole_products() ? products_ : layers_;
  if (!complete_ || taken_ == victims.size()) return false;
  victim = victims[taken_++];
  return true;
}

}  // namespace ilp
