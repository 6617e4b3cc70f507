#include <cmath>

#include "sim/ground/fixes/fix_text.hpp"
#include "sim/ground/report/accuracy_summary.hpp"
#include "sim/ground/report/camera_lines.hpp"
#include "sim/ground/report/capture_summary.hpp"
#include "sim/ground/report/json_parts.hpp"
#include "sim/ground/report/json_writer.hpp"
#include "sim/ground/report/report.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::report {
namespace {

/// Null when it is not known, as for every number that is not finite.
Json number(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json camera_json(const CameraModel& c) {
  Json json = {{"width", c.width}, {"height", c.height}, {"fx", c.fx}, {"fy", c.fy}, {"cx", c.cx},
               {"cy", c.cy},       {"k1", c.k1},         {"k2", c.k2}, {"p1", c.p1}, {"p2", c.p2}};
  if (!c.is_plain()) {
    json.update({{"k3", c.k3}, {"k4", c.k4}, {"k5", c.k5}, {"k6", c.k6}, {"lens", name_of(c.lens)}});
  }
  return json;
}

/// Whether the flight knew it, found it, or only had nominal values.
const char* camera_source(const intake::Flight& flight) {
  if (!flight.camera_record) return "unknown";
  if (!flight.camera_record->frozen || flight.camera_record->source == CameraSource::nominal) return "nominal";
  return flight.calibrations.empty() ? "given" : "found in flight";
}

/// Null where nothing was searched for.
Json calibration_json(const intake::Flight& flight) {
  if (!flight.camera_record || flight.calibrations.empty()) return nullptr;
  const CameraRecord& camera = *flight.camera_record;
  return {{"frozen", bool{camera.frozen}},
          {"source", camera_source(flight)},
          {"keyframe", flight.calibrations.rbegin()->first}};
}

/// Null without a rolling shutter.
Json readout_json(const intake::Flight& flight) {
  if (!flight.camera_record || !has_rolling_shutter(*flight.camera_record)) return nullptr;
  return {{"s", flight.camera_record->readout_s}, {"sigma_s", flight.camera_record->sigma_readout_s}};
}

Json pose_json(const PoseRecord& p) {
  const auto state = p.state == PoseState::final ? "final" : p.state == PoseState::failed ? "failed" : "provisional";
  return {{"state", state},
          {"verdict", words_of(p.verdict)},
          {"scale_source", p.scale_source == ScaleSource::first_baseline ? "first baseline" : name_of(p.scale_source)},
          {"q_cam_from_world", p.q_cam_from_world},
          {"centre", p.centre},
          {"sigma", p.sigma},
          {"matches", p.matches},
          {"pair_inliers", p.pair_inliers},
          {"known_points", p.known_points},
          {"inliers", p.inliers},
          {"points", p.points},
          {"rms_px", p.rms_px},
          {"gric_e", p.gric_e},
          {"gric_h", p.gric_h},
          {"parallax_px", p.parallax_px},
          {"sigma_rotation_rad", p.sigma_rotation_rad},
          {"sigma_direction_rad", p.sigma_direction_rad},
          {"scale_step", p.scale_step}};
}

Json richness_json(const RichnessRecord& r) {
  return {{"index", r.richness},
          {"gradient_fine", r.gradient_fine},
          {"gradient_coarse", r.gradient_coarse},
          {"entropy", r.entropy},
          {"contrast", r.contrast},
          {"relief", r.relief},
          {"slope_steep", r.slope_steep},
          {"slope_excess", r.slope_excess},
          {"roughness_fine", r.roughness_fine},
          {"roughness_coarse", r.roughness_coarse},
          {"curvature", r.curvature},
          {"novelty", r.novelty},
          {"mask_fraction", r.mask_fraction},
          {"has_terrain", bool{r.has_terrain}},
          {"images_learned", r.images_learned}};
}

Json summary_json(const host::ErrorSummary& s) {
  return {{"count", s.count}, {"mean", s.mean}, {"rms", s.rms}, {"median", s.median}, {"max", s.max}};
}

Json position_json(const StripAccuracy& a, const host::ErrorSummary& s) {
  Json json = summary_json(s);
  json["mean_percent_of_length"] = a.percent_of_length(s.mean);
  json["rms_percent_of_length"] = a.percent_of_length(s.rms);
  json["max_percent_of_length"] = a.percent_of_length(s.max);
  json["mean_percent_of_extent"] = a.percent_of_extent(s.mean);
  json["rms_percent_of_extent"] = a.percent_of_extent(s.rms);
  json["max_percent_of_extent"] = a.percent_of_extent(s.max);
  return json;
}

Json accuracy_json(const StripAccuracy& a) {
  Json json = {
      {"poses", a.poses},
      {"scale_reference_from_strip", a.reference_from_strip.scale},
      {"length", a.length},
      {"extent", a.extent},
      {"position", position_json(a, a.position)},
      {"position_with_attitude", position_json(a, a.position_with_attitude)},
      {"rotation_rad", summary_json(a.rotation_rad)},
      {"depth_median_abs_percent_of_flying_height", a.depth_percent ? summary_json(*a.depth_percent) : Json(nullptr)},
      {"too_few", a.poses < fewest_poses}};
  if (a.on_map) {
    json["on_map"] = {{"position_m", summary_json(a.on_map->position)},
                      {"horizontal_m", summary_json(a.on_map->horizontal)},
                      {"nes", std::isfinite(a.on_map->nes) ? Json(a.on_map->nes) : Json(nullptr)}};
  }
  return json;
}

/// The map itself, of which the grid is an overview where it is too large.
Json map_json(const StripResult& strip) {
  const map::MapGeometry& m = strip.geometry;
  return {{"columns", m.columns},      {"rows", m.rows},         {"cell", m.cell},
          {"x_of_first_column", m.x0}, {"y_of_first_row", m.y0}, {"tiles", strip.map.tiles}};
}

Json missing_json(const Report& report) {
  Json all = Json::array();
  for (const intake::Missing& m : report.missing) {
    Json one = {{"keyframe", m.keyframe_id}, {"what", m.what}};
    if (m.strip_id > 0) one["strip"] = m.strip_id;
    if (m.centre) one["centre"] = {m.centre->x(), m.centre->y(), m.centre->z()};
    all.push_back(std::move(one));
  }
  return all;
}

Json roughness_json(const map::Roughness& roughness) {
  return {{"border", roughness.border},
          {"elsewhere", roughness.other},
          {"ratio", roughness.ratio()},
          {"border_samples", roughness.border_samples}};
}

/// One sigma, medians over the cells; null where nothing is stated.
Json height_error_json(const StripResult& strip) {
  const map::HeightErrorParts& parts = strip.usual_errors;
  const auto stated = [](double sigma) { return sigma > 0 ? Json(sigma) : Json(nullptr); };
  return {{"whole", stated(parts.whole())}, {"matching", stated(parts.matching)}, {"poses", stated(parts.poses)},
          {"scale", stated(parts.scale)},   {"tilt", stated(parts.tilt)},         {"place", stated(parts.place)}};
}

Json summary_json(const AccuracySummary& accuracy) {
  return {{"poses", accuracy.poses},
          {"position_mean_percent", accuracy.mean_percent},
          {"position_max_percent", accuracy.max_percent},
          {"rotation_mean_deg", accuracy.rotation_deg},
          {"height_percent", accuracy.height_percent},
          {"depth_percent", accuracy.depth_percent},
          {"keyframe_depth_percent", accuracy.keyframe_depth_percent}};
}

/// Of what is delivered, and of the poses as the flight sent them.
Json summary_json(const Report& report) {
  if (!report.has_reference && !report.score) return nullptr;
  const bool joined = model_is_measured(report);
  Json json = {{"joined_model", nullptr}, {"strips", nullptr}};
  if (joined) json["joined_model"] = summary_json(measured_accuracy(report));
  if (report.score) json["strips"] = summary_json(scored_accuracy(*report.score));
  if (!report.score && !joined) json["strips"] = summary_json(measured_accuracy(report));
  return json;
}

Json grid_json(const StripResult& strip) {
  if (!strip.grid) return nullptr;
  const map::GroundGrid& g = *strip.grid;
  return {{"height_file", "height" + strip.suffix + ".pfm"},
          {"sigma_file", "sigma" + strip.suffix + ".pfm"},
          {"ortho_file", "ortho" + strip.suffix + ".png"},
          {"columns", g.height.width},
          {"rows", g.height.height},
          {"cell", g.cell},
          {"x_of_first_column", g.x0},
          {"y_of_first_row", g.y0},
          {"map", map_json(strip)},
          {"covered_area", strip.map.covered_area},
          {"seams",
           {{"cells", strip.map.seam_cells},
            {"step_median", strip.map.seam_cells > 0 ? Json(strip.map.seam_step_median) : Json(nullptr)},
            {"step_p95", strip.map.seam_cells > 0 ? Json(strip.map.seam_step_p95) : Json(nullptr)},
            {"height", roughness_json(strip.seams.height)},
            {"grey", roughness_json(strip.seams.grey)},
            {"grey_step", roughness_json(strip.seams.grey_step)}}},
          {"height_error", height_error_json(strip)},
          {"mean_plane", {strip.plane.a, strip.plane.b, strip.plane.c}}};
}

Json place_json(const StripResult& strip) {
  const exports::Georeference& place = strip.georeference;
  if (!place.on_a_body()) return nullptr;
  const auto known = [](const std::optional<double>& sigma) { return sigma ? Json(*sigma) : Json(nullptr); };
  return {{"body", place.body},
          {"text", place.sentence},
          {"sigma_m", known(place.place_sigma_m)},
          {"map_sigma_m", known(place.map_sigma_m)},
          {"whole_sigma_m", known(place.whole_sigma_m())}};
}

/// How well the vehicle has measured where the strip is; 0 is not known. Null where a map or nothing says it.
Json navigation_json(const intake::Strip& strip) {
  if (!strip.frame || strip.map) return nullptr;
  const StripFrameRecord& frame = *strip.frame;
  return {{"verdict", words_of(frame.verdict)},
          {"scale_sigma", frame.scale_sigma},
          {"tilt_sigma_rad", frame.tilt_sigma_rad},
          {"heading_sigma_rad", frame.heading_sigma_rad},
          {"horizontal_sigma_m", frame.horizontal_sigma_m},
          {"refused",
           frame.heights_refused + frame.attitudes_refused + frame.positions_refused + frame.velocities_refused}};
}

Json strip_json(const Report& report, const StripResult& s) {
  Json json;
  json["id"] = s.strip.id;
  const std::string end = strip_end(report, s.strip);
  json["end"] = end.empty() ? Json(nullptr) : Json(end);
  json["keyframes"] = s.strip.keyframes.size();
  json["final_poses"] = s.posed;
  json["track_length"] = s.posed > 1 ? Json(s.track_length) : Json(nullptr);
  json["flying_height"] = s.flying_height > 0 ? Json(s.flying_height) : Json(nullptr);
  json["newly_seen_share"] = s.mask_share;
  json["place"] = place_json(s);
  json["grid"] = grid_json(s);
  json["model"] = s.vertices == 0 ? Json(nullptr)
                                  : Json{{"file", "model" + s.suffix + ".ply"},
                                         {"vertices", s.vertices},
                                         {"faces", s.faces},
                                         {"cell_stride", s.stride}};
  json["colmap"] = s.colmap.images == 0 ? Json(nullptr)
                                        : Json{{"folder", "colmap" + s.suffix},
                                               {"images", s.colmap.images},
                                               {"points", s.colmap.points},
                                               {"observations", s.colmap.observations}};
  json["accuracy"] = s.accuracy ? accuracy_json(*s.accuracy) : Json(nullptr);
  json["unit"] = intake::unit_of(report.flight, s.strip);
  const LengthUnit length = length_unit(report, s);
  json["length_unit"] = {{"factor", length.factor}, {"name", length.name}};
  json["surface_file"] =
      s.vertices == 0 ? Json(nullptr) : Json("model" + s.suffix + (report.with_copies ? ".ply" : ".glb"));
  json["place_text"] = s.place;
  json["files"] = s.files;
  json["navigation"] = navigation_json(s.strip);
  return json;
}

Json product_json(const std::optional<intake::ProductAccount>& product) {
  if (!product) return nullptr;
  return {{"file", product->file},
          {"bytes", product->bytes},
          {"grant_bytes", product->grant_bytes == 0 ? Json(nullptr) : Json(product->grant_bytes)},
          {"within_grant", product->grant_bytes == 0 ? Json(nullptr) : Json(!over_grant(*product))},
          {"scheme", words_of(product->scheme)},
          {"layers", product->layers}};
}

Json keyframe_accuracy_json(const StripResult* strip, std::int64_t id) {
  if (strip == nullptr || !strip->accuracy) return nullptr;
  const auto found = strip->accuracy->keyframes.find(id);
  if (found == strip->accuracy->keyframes.end()) return nullptr;
  const KeyframeAccuracy& a = found->second;
  Json json = {{"position", a.position}, {"rotation_rad", a.rotation_rad}, {"depth", nullptr}};
  if (a.depth) {
    json["depth"] = {{"pixels", a.depth->pixels},
                     {"flying_height", a.depth->flying_height},
                     {"median_abs", a.depth->median_abs},
                     {"median_abs_percent", a.depth->median_abs_percent},
                     {"own_scale_median_abs_percent", a.depth->own_scale_percent},
                     {"bias_percent", a.depth->bias_percent}};
  }
  return json;
}

/// What keyframes/ has of it.
Json pictures_json(const intake::Keyframe& k) {
  Json names = Json::array();
  if (k.has_image()) names.push_back("image");
  if (k.has_depth()) names.push_back("depth");
  if (k.has_mask()) names.push_back("mask");
  return names;
}

Json keyframe_json(const Report& report, const intake::Keyframe& k, const StripResult* strip) {
  Json json;
  json["id"] = k.id;
  json["strip"] = k.strip_id;
  json["name"] = k.name;
  json["time_ns"] = k.record ? Json(k.record->time_ns) : Json(nullptr);
  json["verdict"] = keyframe_verdict(k);
  json["overlap_with_previous"] = k.record ? Json(k.record->overlap) : Json(nullptr);
  json["pose"] = k.pose ? pose_json(*k.pose) : Json(nullptr);
  json["depth"] = !k.depth ? Json(nullptr)
                           : Json{{"verdict", words_of(k.depth->verdict)},
                                  {"partner", k.depth->partner_id},
                                  {"baseline", k.depth->baseline},
                                  {"valid_px", k.depth->valid},
                                  {"supported_px", k.depth->supported},
                                  {"newly_seen_px", k.mask_record ? Json(k.mask_record->newly_seen) : Json(nullptr)},
                                  {"median_sigma_px", k.depth->median_sigma_px}};
  json["richness"] = k.richness ? richness_json(*k.richness) : Json(nullptr);
  json["image_product"] = product_json(k.product(ProductKind::image));
  json["depth_product"] = product_json(k.product(ProductKind::depth));
  const auto quality = report.image_quality.find(k.id);
  json["image_psnr_db"] = quality == report.image_quality.end() ? Json(nullptr)
                                                                : Json{{"inside_mask", quality->second.inside_db},
                                                                       {"outside_mask", quality->second.outside_db}};
  json["error"] = keyframe_accuracy_json(strip, k.id);
  json["frame"] = k.record ? Json(k.record->frame_id) : Json(nullptr);
  json["index"] = k.record ? Json(k.record->index) : Json(nullptr);
  json["degraded"] = k.record ? Json(k.record->degraded) : Json(nullptr);
  json["width"] = k.camera.width;
  json["height"] = k.camera.height;
  json["newly_seen_px"] = k.mask_record ? Json(k.mask_record->newly_seen) : Json(nullptr);
  json["pictures"] = pictures_json(k);
  return json;
}

Json spread_json(const Spread& s) {
  return {{"count", s.count}, {"mean", s.mean}, {"standard_deviation", s.deviation}};
}

Json capture_counts_json(const CaptureSummary& summary) {
  Json json = Json::object();
  for (std::size_t source = 0; source < capture_sources; ++source) {
    Json states = Json::object();
    for (std::size_t state = 0; state < capture_states; ++state) {
      if (summary.counts[source][state] > 0) states[capture_state_words(state)] = summary.counts[source][state];
    }
    if (!states.empty()) json[capture_source_words(source)] = states;
  }
  return json;
}

Json capture_json(const intake::Flight& flight, const CaptureRecord& c) {
  const std::string reason = capture_reason(flight, c);
  const bool exposed = c.state == CaptureState::exposed;
  return {{"id", c.id},
          {"source", capture_source_words(source_index(c))},
          {"state", capture_state_words(state_index(c))},
          {"requested_ns", c.requested_ns},
          {"issued_ns", c.issued_ns},
          {"exposed_ns", exposed ? Json(c.exposed_ns) : Json(nullptr)},
          {"exposed_minus_requested_ms", exposure_delay_ms(c)},
          {"command", is_telecommanded(c) ? Json(c.command_id) : Json(nullptr)},
          {"frame", exposed ? Json(c.frame_id) : Json(nullptr)},
          {"forecast_overlap", c.overlap},
          {"forecast_sigma", c.overlap_sigma},
          {"speed_px_s", c.speed_px_s},
          {"reason", reason.empty() ? Json(nullptr) : Json(reason)}};
}

Json captures_json(const Report& report) {
  if (report.flight.captures.empty()) return nullptr;
  const CaptureSummary s = summarise_captures(report.flight, report.target_overlap);
  Json json;
  json["by_source_and_state"] = capture_counts_json(s);
  json["frames_per_keyframe"] = s.frames_per_keyframe;
  json["achieved_minus_target_overlap"] = spread_json(s.achieved);
  json["forecast_minus_measured_overlap"] = spread_json(s.forecast_error);
  json["forecasts_unchecked"] = s.forecasts_unchecked;
  json["forecasts_with_sigma"] = s.with_sigma;
  json["share_within_1_sigma"] = s.within_1_sigma;
  json["share_within_2_sigma"] = s.within_2_sigma;
  json["checks"] = Json::array();
  for (const ForecastCheck& check : s.forecasts) {
    json["checks"].push_back({{"capture", check.capture_id},
                              {"keyframe", check.keyframe_id == 0 ? Json(nullptr) : Json(check.keyframe_id)},
                              {"forecast", check.forecast},
                              {"measured", check.measured},
                              {"sigma", check.sigma},
                              {"source", capture_source_words(check.source)}});
  }
  json["list"] = Json::array();
  for (const auto& [id, capture] : report.flight.captures) {
    json["list"].push_back(capture_json(report.flight, capture));
  }
  json["states"] = Json::array();
  for (std::size_t state = 0; state < capture_states; ++state) {
    if (s.by_state[state] > 0) json["states"].push_back(capture_state_words(state));
  }
  return json;
}

Json info_json(const intake::FlightInfo& i) {
  return {{"source", i.source},
          {"notes", i.notes},
          {"software", i.software},
          {"profile", i.profile},
          {"seed", number(i.seed)},
          {"frames", number(i.frames)},
          {"keyframes", number(i.keyframes)},
          {"wall_s", number(i.wall_s)},
          {"cpu_s", number(i.cpu_s)},
          {"peak_rss_mib", number(i.peak_rss_mib)},
          {"flight_cpu_s", number(i.flight_cpu_s)},
          {"static_bytes", number(i.static_bytes)}};
}

Json totals_json(const ReportTotals& t) {
  return {{"keyframes", t.keyframes},
          {"final_poses", t.posed},
          {"with_depth", t.with_depth},
          {"products", t.products},
          {"products_over_grant", t.over_grant},
          {"product_bytes", t.product_bytes},
          {"product_bits_per_pixel",
           t.product_pixels > 0 ? Json(8.0 * static_cast<double>(t.product_bytes) / t.product_pixels) : Json(nullptr)},
          {"files_used", t.files_used},
          {"files_skipped", t.files_skipped},
          {"received_bytes", t.received_bytes}};
}

Json steps_json(const model::HeightSteps& steps) {
  const auto known = [&](double percent) { return steps.samples > 0 ? Json(percent) : Json(nullptr); };
  return {{"samples", steps.samples},
          {"pairs", steps.pairs},
          {"median_percent", known(steps.median_percent)},
          {"p95_percent", known(steps.p95_percent)}};
}

/// As told of all fixes in `fixes`, those of one model.
Json on_map_json(const model::OnMap& on_map) {
  const auto known = [](double sigma) { return sigma > 0 ? Json(sigma) : Json(nullptr); };
  Json fixes = Json::array();
  for (const model::OnMap::Fix& fix : on_map.fixes)
    fixes.push_back({{"keyframe", fix.keyframe_id}, {"used", fix.used}, {"off_sigmas", fix.sigmas}});
  return {{"map", fixes::map_name(on_map.map.map_id)},
          {"body", name_of(on_map.map.body)},
          {"longitude_deg", on_map.map.longitude_deg},
          {"latitude_deg", on_map.map.latitude_deg},
          {"map_sigma_m", on_map.map.map_sigma_m},
          {"place_sigma_m", known(on_map.map.place_sigma_m)},
          {"used", on_map.used},
          {"error_factor", on_map.error_factor},
          {"image_factor", on_map.image_factor},
          {"removed_m", {{"median", on_map.removed_m.median}, {"largest", on_map.removed_m.max}}},
          {"fixes", fixes}};
}

Json joined_json(const model::JoinedFlight& joined) {
  Json models = Json::array(), apart = Json::array();
  for (const model::JoinedModel& one : joined.models) {
    Json links = Json::array(), members = Json::array();
    for (const model::ClosedLink& link : one.links) {
      links.push_back({{"keyframe", link.keyframe_id},
                       {"place", link.place_id},
                       {"points", link.points},
                       {"error_by_flight_px", link.before_px > 0 ? Json(link.before_px) : Json(nullptr)},
                       {"error_px", link.points > 0 ? Json(link.after_px) : Json(nullptr)},
                       {"strips", {link.strip_id, link.place_strip_id}}});
    }
    for (const model::JoinedModel::Member& member : one.members) {
      members.push_back(
          {{"keyframe", member.keyframe_id}, {"strip", member.strip_id}, {"posed_by_flight", member.posed_by_flight}});
      if (member.attached_to != 0) members.back()["hangs_at"] = member.attached_to;
      members.back()["centre"] = member.after;
      if (member.posed_by_flight) members.back()["centre_by_flight"] = member.before;
    }
    models.push_back(
        {{"strip", one.strip_id},
         {"strips", one.strips},
         {"keyframes", members},
         {"points", one.points},
         {"sightings", one.sightings},
         {"median_error_px", one.median_error_px},
         {"by_ties", one.by_ties},
         {"height_steps", {{"before", steps_json(one.steps_before)}, {"after", steps_json(one.steps_after)}}},
         {"links", links}});
    if (one.on_map) models.back()["on_map"] = on_map_json(*one.on_map);
  }
  for (const model::StripApart& one : joined.apart)
    apart.push_back({{"strip", one.strip_id}, {"keyframes", one.keyframes}, {"why", one.why}});
  return {{"models", models}, {"apart", apart}};
}

Json landing_json(const std::vector<StripResult>& strips) {
  Json all = Json::array();
  for (const StripResult& strip : strips) {
    if (!strip.landing) continue;
    Json reported = {{"strip", strip.strip.id}, {"fault", strip.landing->fault}, {"sites", Json::array()}};
    if (const auto& map = strip.landing->map) {
      reported["footprint_m"] = map->limits.footprint_m;
      reported["slope_deg"] = map->limits.slope_rad / landing::degree;
      reported["step_m"] = map->limits.step_m;
      reported["least_safe"] = landing::least_safe;
      for (const landing::LandingSite& site : map->sites) {
        reported["sites"].push_back({{"safe", site.safe},
                                     {"slope_deg", site.slope_rad / landing::degree},
                                     {"roughness_m", site.roughness_m},
                                     {"step_m", site.step_m},
                                     {"place", {site.x, site.y, site.z}}});
      }
    }
    all.push_back(std::move(reported));
  }
  return all;
}

Json control_json(const std::vector<control::StripControl>& strips) {
  const auto number = [](double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); };
  Json json = Json::array();
  for (const control::StripControl& strip : strips) {
    Json points = Json::array();
    for (const control::PointResult& p : strip.points) {
      points.push_back({{"name", p.name},
                        {"check", p.check},
                        {"used", p.used},
                        {"fault", p.fault.empty() ? Json(nullptr) : Json(p.fault)},
                        {"marks", p.marks},
                        {"rms_px", p.rms_px},
                        {"residual_m", p.residual ? Json({p.residual->x(), p.residual->y(), p.residual->z()}) : Json()},
                        {"expected_m", p.expected_m}});
    }
    json.push_back({{"strip", strip.strip},
                    {"placed", strip.placed},
                    {"metres_per_unit", strip.metres_per_unit},
                    {"used", strip.used},
                    {"used_rmse_m", number(strip.used_rmse_m)},
                    {"checked", strip.checked},
                    {"check_rmse_m", number(strip.check_rmse_m)},
                    {"points", points}});
  }
  return json;
}

/// Of frames whose record, or that of their keyframe, came down.
std::map<std::int64_t, TimeNs> frame_times(const intake::Flight& flight) {
  std::map<std::int64_t, TimeNs> times;
  for (const auto& [id, frame] : flight.frames) times[id] = frame.time_ns;
  for (const auto& [id, keyframe] : flight.keyframes) {
    if (keyframe.record) times[keyframe.record->frame_id] = keyframe.record->time_ns;
  }
  return times;
}

Json frame_json(std::int64_t id, const OverlapRecord& overlap, const std::map<std::int64_t, TimeNs>& times) {
  const auto time = times.find(id);
  return {{"id", id},
          {"time_ns", time == times.end() ? Json(nullptr) : Json(time->second)},
          {"keyframe", overlap.keyframe_id},
          {"overlap", overlap.overlap},
          {"verdict", words_of(overlap.verdict)},
          {"decision", overlap.decision},
          {"ncc", overlap.ncc}};
}

Json event_json(const EventRecord& e) {
  return {{"id", e.id},
          {"time_ns", e.time_ns},
          {"severity", host::severity_name(e.severity)},
          {"name", host::event_name(e.code)},
          {"component", e.component},
          {"text", host::event_sentence(e)},
          {"advice", host::event_advice(e.code)},
          {"values", {e.a, e.b}},
          {"place", e.place},
          {"code", e.code},
          {"level", e.severity}};
}

Json component_json(const ComponentRecord& c) {
  return {{"name", c.name},
          {"steps", c.steps},
          {"busy_s", static_cast<double>(c.busy_ns) / 1e9},
          {"longest_step_s", static_cast<double>(c.longest_ns) / 1e9},
          {"overruns", c.overruns},
          {"restarts", c.restarts},
          {"faults", c.faults}};
}

Json file_json(const intake::ReceivedFile& file) {
  return {{"name", file.name},
          {"bytes", file.bytes},
          {"crc32", file.crc32},
          {"fault", file.fault.empty() ? Json(nullptr) : Json(file.fault)}};
}

void write_keyframes(const Report& report, JsonWriter& json) {
  std::map<std::int64_t, const StripResult*> strips;
  for (const StripResult& strip : report.strips) strips[strip.strip.id] = &strip;
  json.begin_list("keyframes");
  for (const auto& [id, keyframe] : report.flight.keyframes) {
    const auto strip = strips.find(keyframe.strip_id);
    json.add(keyframe_json(report, keyframe, strip == strips.end() ? nullptr : strip->second));
  }
  json.end_list();
}

}  // namespace

void write_report_json(const Report& report, std::ostream& out, JsonStyle style) {
  JsonWriter json(out, style);
  json.put("title", report.title);
  json.put("totals", totals_json(totals(report)));
  json.put("accuracy", summary_json(report));
  json.put("target_overlap", report.target_overlap);
  json.put("camera", report.flight.camera ? camera_json(*report.flight.camera) : Json(nullptr));
  json.put("camera_source", camera_source(report.flight));
  json.put("camera_sigma_focal_px",
           report.flight.camera_record ? Json(report.flight.camera_record->sigma_focal_px) : Json(nullptr));
  json.put("flight", report.info ? info_json(*report.info) : Json(nullptr));
  json.begin_list("strips");
  for (const StripResult& strip : report.strips) json.add(strip_json(report, strip));
  json.end_list();
  write_keyframes(report, json);
  json.begin_list("frames");
  const std::map<std::int64_t, TimeNs> times = frame_times(report.flight);
  for (const auto& [id, overlap] : report.flight.overlaps) json.add(frame_json(id, overlap, times));
  json.end_list();
  json.put("captures", captures_json(report));
  json.begin_list("events");
  for (const EventRecord& event : report.flight.events) json.add(event_json(event));
  json.end_list();
  json.begin_list("components");
  for (const ComponentRecord& component : report.flight.components) json.add(component_json(component));
  json.end_list();
  json.begin_list("files");
  for (const intake::ReceivedFile& file : report.outbox.files) json.add(file_json(file));
  json.end_list();
  json.put("missing", missing_json(report));
  if (!report.joined.models.empty() || !report.joined.apart.empty()) json.put("joined", joined_json(report.joined));
  if (!report.fixes.empty()) json.put("fixes", fixes::json_of(report.fixes));
  if (const Json landing = landing_json(report.strips); !landing.empty()) json.put("landing", landing);
  if (!report.control.empty()) json.put("control", control_json(report.control));
  json.put("remarks", report.flight.remarks);
  json.put("has_reference", report.has_reference);
  json.put("camera_frozen",
           report.flight.camera_record ? Json(bool{report.flight.camera_record->frozen}) : Json(nullptr));
  json.put("camera_calibration", calibration_json(report.flight));
  json.put("camera_readout", readout_json(report.flight));
  json.put("estimated_errors", estimated_errors_json(report));
  json.put("housekeeping", housekeeping_json(report.flight));
  json.put("storage", storage_json(report.flight));
  json.put("timing", timing_json(report.flight));
  json.put("score", report.score ? score_json(*report.score) : Json(nullptr));
  json.put("sentences",
           {{"nothing", nothing_lines(report)},
            {"camera", camera_lines(report.flight)},
            {"control", report.control.empty() ? std::vector<std::string>{} : control::lines_of(report.control)},
            {"fixes", fixes::lines_of(report.fixes)},
            {"on_map", fixes::lines_of(report.joined)}});
  json.put("viewer", report.has_viewer);
  json.put("copies", report.with_copies);
  json.end();
}

}  // namespace ilp::report
