#include "sim/ground/ground_run.hpp"

#include <cmath>
#include <memory>
#include <ostream>
#include <stdexcept>

#include "cfg/mission.hpp"
#include "sim/ground/export_files.hpp"
#include "sim/ground/flight_database.hpp"
#include "sim/ground/flight_info.hpp"
#include "sim/ground/grid_surface.hpp"
#include "sim/ground/host_files.hpp"
#include "sim/ground/image_quality.hpp"
#include "sim/ground/ply_writer.hpp"
#include "sim/ground/previous_results.hpp"
#include "sim/ground/reference_files.hpp"
#include "sim/ground/strip_pictures.hpp"
#include "sim/ground/text_format.hpp"
#include "sim/ground/viewer_page.hpp"

namespace ilp::ground {
namespace {
namespace fs = std::filesystem;

std::unique_ptr<Reference> open_reference(const GroundOptions& options) {
  if (!options.truth.empty())
    return std::make_unique<ReferenceFiles>(options.truth / "poses.txt", options.truth / "depth");
  if (!options.reference.empty()) return std::make_unique<ReferenceFiles>(options.reference, fs::path());
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

void measure_strip(const Flight& flight, StripResult& result) {
  const std::vector<TrackPoint> track = track_of(flight, result.strip);
  result.posed = track.size();
  for (std::size_t i = 1; i < track.size(); ++i) result.track_length += (track[i].centre - track[i - 1].centre).norm();
  std::vector<double> heights;
  double masked = 0, pixels = 0;
  for (const TrackPoint& point : track) {
    const Keyframe& keyframe = flight.keyframes.at(point.keyframe_id);
    pixels += static_cast<double>(keyframe.camera.width) * keyframe.camera.height;
    if (keyframe.inverse_depth.empty()) continue;
    std::vector<double> depths;
    for (const float d : keyframe.inverse_depth.samples) {
      if (d > 0) depths.push_back(1.0 / d);
    }
    masked += static_cast<double>(depths.size());
    if (!depths.empty()) heights.push_back(median(std::move(depths)));
  }
  result.flying_height = heights.empty() ? 0 : median(std::move(heights));
  result.mask_share = pixels > 0 ? masked / pixels : 0;
}

void merge_and_export(const GroundOptions& options, const Flight& flight, PixelRays& rays, StripResult& result) {
  const Strip& strip = result.strip;
  result.colmap = write_colmap_model(flight, strip, options.out / ("colmap" + result.suffix));
  result.grid = build_grid(flight, strip, {}, rays);
  if (!result.grid) return;
  result.plane = mean_plane(*result.grid);
  export_grid(*result.grid, result.suffix, options.out);
  result.stride = stride_for(*result.grid, options.max_vertices);
  const SurfaceMesh mesh = grid_surface(*result.grid, result.stride, {});
  result.vertices = mesh.vertices.size();
  result.faces = mesh.faces.size();
  write_file(options.out / ("model" + result.suffix + ".ply"),
             ply_bytes(mesh, "strip " + std::to_string(strip.id) + ", unit: " + unit_of(flight, strip)));
}

void report_skipped(const Outbox& outbox, std::ostream& messages) {
  for (const ReceivedFile& file : outbox.files) {
    if (!file.fault.empty()) messages << "skipped " << file.name << ": " << file.fault << "\n";
  }
}

std::vector<const Strip*> strips_with_poses_first(const Flight& flight) {
  std::vector<const Strip*> posed, others;
  for (const auto& [id, strip] : flight.strips) {
    if (strip.keyframes.empty()) continue;
    (track_of(flight, strip).empty() ? others : posed).push_back(&strip);
  }
  posed.insert(posed.end(), others.begin(), others.end());
  return posed;
}

void write_keyframes(const GroundOptions& options, const Flight& flight) {
  const fs::path folder = options.out / "keyframes";
  make_output_folder(folder);
  for (const auto& [id, keyframe] : flight.keyframes) export_keyframe(keyframe, folder);
}

std::string nothing_usable(const fs::path& folder, const Outbox& outbox) {
  return "nothing usable in " + folder.string() + ": " +
         (outbox.files.empty() ? "the folder is empty" : counted(outbox.files.size(), "file") + ", none of them whole");
}

// The results of an earlier run, with more to see, stay.
void write_empty_viewer(const fs::path& out, const std::string& title, const std::string& reason) {
  if (!viewer_available() || fs::exists(out / "report.html")) return;
  make_output_folder(out);
  write_file(out / "viewer.html", viewer_empty_html(title, reason));
}

}  // namespace

Report run_ground(const GroundOptions& options, std::ostream& messages) {
  // Inputs that the user named are checked before any work: a typing error shows at once.
  const std::unique_ptr<Reference> reference = open_reference(options);
  Report report;
  if (!options.flight_info.empty()) report.info = read_flight_info(options.flight_info);
  if (!options.score.empty()) report.score = read_score(options.score);
  report.outbox = read_outbox(options.outbox);
  if (!options.flight_db.empty()) {
    // What came down is read last, so that it stands over what the database says.
    std::vector<RecordEntry> onboard = read_flight_database(options.flight_db);
    onboard.insert(onboard.end(), std::make_move_iterator(report.outbox.records.begin()),
                   std::make_move_iterator(report.outbox.records.end()));
    report.outbox.records = std::move(onboard);
  }
  report.flight = build_flight(report.outbox);
  report_skipped(report.outbox, messages);
  const ReportTotals sums = totals(report);
  report.title = title_of(options);
  if (sums.files_used == 0) {
    const std::string reason = nothing_usable(options.outbox, report.outbox);
    write_empty_viewer(options.out, report.title, reason);
    throw std::runtime_error(reason);
  }
  make_output_folder(options.out);
  remove_previous_results(options.out);
  if (!options.acknowledge.empty()) write_acknowledgements(report.outbox, options.acknowledge);

  report.target_overlap =
      options.target_overlap > 0
          ? options.target_overlap
          : (report.info ? report.info->target_overlap : std::nullopt).value_or(MissionParameters{}.target_overlap);
  report.has_reference = reference != nullptr;
  write_keyframes(options, report.flight);
  if (!options.images.empty()) measure_image_quality(options.images, report);
  PixelRays rays;
  for (const Strip* strip : strips_with_poses_first(report.flight)) {
    StripResult& result = report.strips.emplace_back();
    result.strip = *strip;
    result.suffix = report.strips.size() == 1 ? "" : "-strip-" + std::to_string(strip->id);
    measure_strip(report.flight, result);
    merge_and_export(options, report.flight, rays, result);
    if (reference) result.accuracy = measure_accuracy(report.flight, *strip, *reference);
  }
  write_file(options.out / "report.json", report_json(report));
  write_file(options.out / "report.html", report_html(report));
  if (viewer_available()) write_file(options.out / "viewer.html", viewer_html(report));
  return report;
}

}  // namespace ilp::ground
