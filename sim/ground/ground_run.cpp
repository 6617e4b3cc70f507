#include "sim/ground/ground_run.hpp"

#include <map>
#include <memory>
#include <ostream>
#include <stdexcept>

#include "cfg/mission.hpp"
#include "sim/ground/export/flight_tables.hpp"
#include "sim/ground/export/look_round.hpp"
#include "sim/ground/export/strip_exports.hpp"
#include "sim/ground/intake/catalogue.hpp"
#include "sim/ground/intake/flight_info.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/model/height_steps.hpp"
#include "sim/ground/model/joined_model.hpp"
#include "sim/ground/previous_results.hpp"
#include "sim/ground/report/accuracy.hpp"
#include "sim/ground/report/report.hpp"
#include "sim/ground/viewer/viewer_page.hpp"
#include "sim/host/files.hpp"
#include "sim/host/progress.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::ground {
namespace {
namespace fs = std::filesystem;

std::unique_ptr<report::Reference> open_reference(const GroundOptions& options) {
  if (!options.truth.empty())
    return std::make_unique<report::ReferenceFiles>(options.truth / "poses.txt", options.truth / "depth");
  if (!options.reference.empty()) return std::make_unique<report::ReferenceFiles>(options.reference, fs::path());
  return nullptr;
}

std::string title_of(const GroundOptions& options) {
  if (!options.title.empty()) return options.title;
  const fs::path folder = fs::absolute(options.outbox).lexically_normal();
  fs::path name = folder.filename().empty() ? folder.parent_path().filename() : folder.filename();
  // The outbox of a flight has a fixed name: its flight's folder says more.
  if (name == "outbox" && folder.parent_path().has_filename()) name = folder.parent_path().filename();
  return name.string();
}

void measure_strip(const report::Report& report, report::StripResult& result) {
  const std::vector<intake::TrackPoint> track = intake::track_of(report.flight, result.strip);
  result.posed = track.size();
  for (std::size_t i = 1; i < track.size(); ++i) result.track_length += (track[i].centre - track[i - 1].centre).norm();
  std::vector<double> heights;
  double masked = 0, pixels = 0;
  for (const intake::TrackPoint& point : track) {
    const intake::Keyframe& keyframe = report.flight.keyframes.at(point.keyframe_id);
    const map::KeyframeLook& look = report.looks.at(point.keyframe_id);
    pixels += static_cast<double>(keyframe.camera.width) * keyframe.camera.height;
    masked += static_cast<double>(look.depth_pixels);
    if (look.median_depth > 0) heights.push_back(look.median_depth);
  }
  result.flying_height = heights.empty() ? 0 : host::median(std::move(heights));
  result.mask_share = pixels > 0 ? masked / pixels : 0;
}

map::KeyframeViews views_of(const report::Report& report, const intake::Strip& strip) {
  map::KeyframeViews views;
  for (const std::int64_t id : strip.keyframes) {
    const map::KeyframeLook& look = report.looks.at(id);
    if (look.ground_step > 0) views[id] = map::view_of(look);
  }
  return views;
}

void merge_and_export(const GroundOptions& options, const report::Report& report, const exports::Anchors* anchors,
                      intake::Catalogue& catalogue, report::StripResult& result, std::ostream& messages) {
  const intake::Strip& strip = result.strip;
  result.colmap = exports::write_colmap_model(report.flight, strip, options.out / ("colmap" + result.suffix));
  const auto map = map::merge_strip(report.flight, strip, views_of(report, strip), catalogue, {},
                                    host::Progress(messages, "merging strip " + std::to_string(strip.id)));
  if (!map) {
    (void)exports::export_track(report.flight, anchors, options.out, result);
    return;
  }
  result.geometry = map->mosaic.geometry;
  result.map = map->statistics;
  result.seams = map::measure_seams(map->mosaic);
  result.grid = map::overview(map->mosaic, {});
  result.plane = map::mean_plane(*result.grid);
  exports::export_grid(*result.grid, result.suffix, options.out);
  exports::export_strip(report.flight, map->mosaic, anchors, options.max_vertices, options.out, result);
}

void report_skipped(const intake::Outbox& outbox, std::ostream& messages) {
  for (const intake::ReceivedFile& file : outbox.files) {
    if (!file.fault.empty()) messages << "skipped " << file.name << ": " << file.fault << "\n";
  }
}

std::vector<const intake::Strip*> strips_with_poses_first(const intake::Flight& flight) {
  std::vector<const intake::Strip*> posed, others;
  for (const auto& [id, strip] : flight.strips) {
    if (strip.keyframes.empty()) continue;
    (intake::track_of(flight, strip).empty() ? others : posed).push_back(&strip);
  }
  posed.insert(posed.end(), others.begin(), others.end());
  return posed;
}

std::string nothing_usable(const fs::path& folder, const intake::Outbox& outbox) {
  return "nothing usable in " + folder.string() + ": " +
         (outbox.files.empty() ? "the folder is empty"
                               : host::counted(outbox.files.size(), "file") + ", none of them whole");
}

// The results of an earlier run, with more to see, stay.
void write_empty_viewer(const fs::path& out, const std::string& title, const std::string& reason) {
  if (!viewer::viewer_available() || fs::exists(out / "report.html")) return;
  host::make_output_folder(out);
  host::write_file(out / "viewer.html", viewer::viewer_empty_html(title, reason));
}

[[noreturn]] void stop_for_nothing(const GroundOptions& options, const report::Report& report) {
  const std::string reason = nothing_usable(options.outbox, report.outbox);
  write_empty_viewer(options.out, report.title, reason);
  throw std::runtime_error(reason);
}

void forget(const fs::path& catalogue) {
  for (const char* part : {"", "-wal", "-shm"}) fs::remove(catalogue.string() + part);
}

intake::Outbox everything_held(const GroundOptions& options, intake::Catalogue& catalogue) {
  intake::Outbox outbox = catalogue.outbox();
  if (!options.flight_db.empty()) {
    // What came down is read last, so that it stands over what the database says.
    std::vector<intake::RecordEntry> onboard = intake::read_flight_database(options.flight_db);
    onboard.insert(onboard.end(), std::make_move_iterator(outbox.records.begin()),
                   std::make_move_iterator(outbox.records.end()));
    outbox.records = std::move(onboard);
  }
  return outbox;
}

/// Products that do not decode leave the catalogue; whether there were any.
bool reject_faulty(report::Report& report, intake::Catalogue& catalogue) {
  std::map<std::string, const intake::ReceivedFile*> files;
  for (const intake::ReceivedFile& file : report.outbox.files) files[file.name] = &file;
  bool any = false;
  for (auto& [id, look] : report.looks) {
    intake::Keyframe& keyframe = report.flight.keyframes.at(id);
    for (std::size_t kind = 0; kind < look.faults.size(); ++kind) {
      if (look.faults[kind].empty() || !keyframe.products[kind]) continue;
      const auto file = files.find(keyframe.products[kind]->file);
      if (file == files.end()) continue;
      intake::ReceivedFile faulty = *file->second;
      faulty.fault = look.faults[kind];
      catalogue.reject(faulty);
      any = true;
    }
  }
  return any;
}

/// Until no product is found damaged: another version of it may be held. Every round takes at least one file out.
void decode_all(const GroundOptions& options, intake::Catalogue& catalogue, report::Report& report,
                std::ostream& messages) {
  do {
    report.outbox = everything_held(options, catalogue);
    report.flight = intake::index_flight(report.outbox);
    for (intake::RecordEntry& entry : report.outbox.records) entry.blobs = {};  // they are in the flight now
    report.joined = model::join_strips(report.flight, host::LongPhases(messages), &catalogue);
    report.looks = exports::look_round(report.flight, options.out / "keyframes", catalogue, messages);
  } while (reject_faulty(report, catalogue));
  catalogue.forget_other_results();
  model::state_height_steps(report.flight, report.joined);
}

void tell_intake(const intake::Catalogue& catalogue, const intake::Catalogue::Intake& intake, std::ostream& messages) {
  if (catalogue.was_set_aside()) {
    messages << "the catalogue was damaged and is set aside: started over from the files that are there\n";
  }
  if (intake.fresh < intake.files) {
    messages << host::counted(intake.fresh, "file") << " new, " << intake.files - intake.fresh << " known\n";
  }
}

}  // namespace

report::Report run_ground(const GroundOptions& options, std::ostream& messages) {
  // Inputs that the user named are checked before any work: a typing error shows at once.
  const std::unique_ptr<report::Reference> reference = open_reference(options);
  report::Report report;
  if (!options.flight_info.empty()) report.info = intake::read_flight_info(options.flight_info);
  if (!options.score.empty()) report.score = report::read_score(options.score);
  report.title = title_of(options);
  std::optional<exports::Anchors> anchors;
  if (!options.anchor.empty())
    anchors = exports::read_anchors(options.anchor, report.info ? exports::flown_body(report.info->source) : nullptr);
  const fs::path catalogue_file = options.out / "catalogue.db";
  if (options.afresh) forget(catalogue_file);
  if (intake::files_of(options.outbox).empty() && !fs::exists(catalogue_file)) stop_for_nothing(options, report);
  host::make_output_folder(options.out);
  intake::Catalogue catalogue(catalogue_file);
  const intake::Catalogue::Intake intake =
      catalogue.take_in(options.outbox, host::Progress(messages, "taking in files"));
  tell_intake(catalogue, intake, messages);
  decode_all(options, catalogue, report, messages);
  report_skipped(report.outbox, messages);
  if (report::totals(report).files_used == 0) stop_for_nothing(options, report);
  remove_previous_results(options.out, report.flight);
  if (!options.acknowledge.empty()) intake::write_acknowledgements(report.outbox, options.acknowledge);

  report.target_overlap =
      options.target_overlap > 0
          ? options.target_overlap
          : (report.info ? report.info->target_overlap : std::nullopt).value_or(MissionParameters{}.target_overlap);
  report.has_reference = reference != nullptr;
  report.missing = intake::missing_of(report.flight);
  if (!report.missing.empty())
    messages << host::counted(report.missing.size(), "thing") << " missing: see the report\n";
  if (!options.images.empty()) report::measure_image_quality(options.images, report);
  for (const intake::Strip* strip : strips_with_poses_first(report.flight)) {
    report::StripResult& result = report.strips.emplace_back();
    result.strip = *strip;
    result.suffix = report.strips.size() == 1 ? "" : "-strip-" + std::to_string(strip->id);
    measure_strip(report, result);
    merge_and_export(options, report, anchors ? &*anchors : nullptr, catalogue, result, messages);
    if (reference) result.accuracy = report::measure_accuracy(report.flight, *strip, *reference);
  }
  report.has_viewer = viewer::viewer_available();
  report.tables = exports::write_flight_tables(report.flight, options.out);
  host::write_file(options.out / "report.json", report::report_json(report));
  host::write_file(options.out / "report.html", report::report_html(report));
  if (report.has_viewer) host::write_file(options.out / "viewer.html", viewer::viewer_html(report));
  return report;
}

}  // namespace ilp::ground
