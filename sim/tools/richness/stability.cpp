#include "sim/tools/richness/stability.hpp"

#include <array>
#include <cstdio>

namespace ilp::richness {

std::vector<ViewingChange> viewing_changes() {
  std::vector<ViewingChange> changes;
  const auto add = [&](std::string_view name, auto change) {
    ViewingChange c{name, {}};
    c.viewing.same_ground = true;
    change(c);
    changes.push_back(c);
  };
  add("as it is", [](ViewingChange&) {});
  add("gain 0.5", [](ViewingChange& c) { c.viewing.gain = 0.5; });
  add("gain 2", [](ViewingChange& c) { c.viewing.gain = 2; });
  add("20 grey levels more", [](ViewingChange& c) { c.viewing.offset_grey = 20; });
  add("20 grey levels less", [](ViewingChange& c) { c.viewing.offset_grey = -20; });
  add("height 0.7", [](ViewingChange& c) { c.viewing.height = 0.7; });
  add("height 1.5", [](ViewingChange& c) { c.viewing.height = 1.5; });
  add("read noise + 2", [](ViewingChange& c) { c.viewing.read_noise = 2; });
  add("haze + 0.2", [](ViewingChange& c) { c.viewing.haze = 0.2; });
  add("exact depth", [](ViewingChange& c) { c.viewing.true_depth = true; });
  add("no depth", [](ViewingChange& c) { c.with_depth = false; });
  return changes;
}

std::vector<StabilityRow> stability(const WorldRange& range, const std::vector<ViewingChange>& changes,
                                    const RichnessParams& params, std::size_t threads) {
  std::vector<StabilityRow> rows;
  std::vector<EvaluatedImage> base;
  for (const ViewingChange& change : changes) {
    std::vector<EvaluatedImage> images = evaluate(range, change.viewing, params, threads, change.with_depth);
    if (base.empty()) base = images;
    StabilityRow row;
    row.name = change.name;
    std::vector<double> before;
    std::vector<double> after;
    for (std::size_t i = 0; i < images.size(); ++i) {
      images[i].label = base[i].label;
      before.push_back(base[i].index);
      after.push_back(images[i].index);
      row.mean_change += (after[i] - before[i]) / static_cast<double>(images.size());
    }
    row.auc = area_under_roc(scored(images));
    row.rank_correlation = rank_correlation(before, after);
    rows.push_back(row);
  }
  return rows;
}

std::string stability_table(const std::vector<StabilityRow>& rows) {
  std::string table = "                       AUC    95 % interval   rank correlation   mean change of the index\n";
  for (const StabilityRow& row : rows) {
    std::array<char, 160> line{};
    std::snprintf(line.data(), line.size(), "%-22s %.3f  %.3f to %.3f  %.3f              %+.3f\n",
                  std::string(row.name).c_str(), row.auc.value, row.auc.low, row.auc.high, row.rank_correlation,
                  row.mean_change);
    table += line.data();
  }
  return table;
}

}  // namespace ilp::richness
