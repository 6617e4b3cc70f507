#include "sim/ground/work_steps.hpp"

#include <ostream>

#include "sim/ground/export/quick_looks.hpp"
#include "sim/ground/map/strip_map.hpp"
#include "sim/ground/received_flight.hpp"
#include "sim/ground/run_record.hpp"
#include "sim/ground/tasks/work_plan.hpp"
#include "sim/host/files.hpp"
#include "sim/host/progress.hpp"

namespace ilp::ground {
namespace {

std::vector<tasks::StripTiles> tiles_of(const report::Report& report) {
  std::vector<tasks::StripTiles> strips;
  for (const intake::Strip* strip : strips_with_poses_first(report.flight)) {
    const map::KeyframeViews views = views_of(report, *strip);
    if (!views.empty()) strips.push_back({strip->id, map::plan_map(views)});
  }
  return strips;
}

std::vector<tasks::StripFinish> finishes_of(const report::Report& report, intake::Catalogue& catalogue,
                                            std::ostream& messages) {
  std::vector<tasks::StripFinish> strips;
  for (const tasks::StripTiles& strip : tiles_of(report)) {
    const map::PaintedTiles painted =
        map::paint_tiles(report.flight, strip.strip_id, strip.plan, catalogue, {},
                         host::Progress(messages, "Merging strip " + std::to_string(strip.strip_id)));
    strips.push_back({strip.strip_id, strip.plan.cell,
                      map::plan_finish(strip.plan, painted.summaries, map::map_balance(painted.totals))});
  }
  return strips;
}

/// The record of the run before does not know what tasks will write.
void leave_pictures_to_tasks(const std::vector<std::int64_t>& ids, const std::filesystem::path& out,
                             RunRecord& before) {
  for (const std::int64_t id : ids) {
    const std::string prefix = "keyframes/" + host::six_digits(id) + "-";
    std::erase_if(before.files, [&](const auto& file) { return file.first.starts_with(prefix); });
  }
  write_record(before, out);
}

}  // namespace

std::size_t plan_work(const GroundOptions& options, tasks::WorkKind kind, std::size_t tasks, std::ostream& messages) {
  if (summary_if_unchanged(options, messages)) return 0;
  report::Report report;
  RunRecord before;
  const std::unique_ptr<intake::Catalogue> catalogue = open_and_take_in(options, report, before, messages);
  if (kind == tasks::WorkKind::quick_looks) {
    index_held(options, *catalogue, report, messages);
    const std::vector<std::int64_t> ids =
        exports::keyframes_without_quick_look(report.flight, options.out / "keyframes", *catalogue);
    leave_pictures_to_tasks(ids, options.out, before);
    return tasks::plan_quick_looks(report.flight, ids, tasks, options.out);
  }
  decode_held(options, *catalogue, report, messages);
  if (kind == tasks::WorkKind::tiles) {
    return tasks::plan_tiles(report.flight, tiles_of(report), *catalogue, tasks, options.out);
  }
  return tasks::plan_finish(finishes_of(report, *catalogue, messages), *catalogue, tasks, options.out);
}

}  // namespace ilp::ground
