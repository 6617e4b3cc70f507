// The top of the page: what was covered, how accurate, what it cost, what went wrong.
#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/report/accuracy_summary.hpp"
#include "sim/ground/report/camera_lines.hpp"
#include "sim/ground/report/page_sections.hpp"
#include "sim/host/statistics.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

std::string coverage_sentence(const Report& report, const ReportTotals& t) {
  std::string text = std::to_string(t.posed) + " of " + host::counted(t.keyframes, "keyframe") +
                     (t.posed == 1 ? " has" : " have") + " a final pose and " + std::to_string(t.with_depth) +
                     " an elevation map, in " + host::counted(report.strips.size(), "strip");
  if (report.strips.size() == 1 && report.strips[0].track_length > 0) {
    const StripResult& s = report.strips[0];
    const auto [factor, unit] = length_unit(report, s);
    text += " of " + host::brief(factor * s.track_length) + " " + unit;
    if (s.flying_height > 0) text += " (" + host::brief(s.track_length / s.flying_height) + " times the flying height)";
  }
  return text + ". ";
}

/// Of the model that is delivered; without one, of the score or of what the reference gives.
AccuracySummary accuracy_of(const Report& report) {
  return report.score && !model_is_measured(report) ? scored_accuracy(*report.score) : measured_accuracy(report);
}

std::string accuracy_sentence(const Report& report) {
  if (!report.has_reference && !report.score) return "There is no reference to measure the accuracy against. ";
  const AccuracySummary accuracy = accuracy_of(report);
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "Against the reference, " : "; ") + part; };
  if (std::isfinite(accuracy.mean_percent)) {
    add(std::string("camera positions") + (model_is_measured(report) ? " of the joined model" : "") + " are off by " +
        host::brief(accuracy.mean_percent) + " % of the distance flown on average and by " +
        host::brief(accuracy.max_percent) + " % at most");
  }
  if (std::isfinite(accuracy.height_percent))
    add("merged heights by " + host::brief(accuracy.height_percent) + " % of the flying height (median)");
  if (std::isfinite(accuracy.depth_percent))
    add("depths of single pixels by " + host::brief(accuracy.depth_percent) + " % of the flying height (median)");
  if (std::isfinite(accuracy.keyframe_depth_percent))
    add("depths of the median keyframe by " + host::brief(accuracy.keyframe_depth_percent) + " % of the flying height");
  return text.empty() ? "Too few poses match the reference to measure the accuracy. " : text + ". ";
}

std::string trouble_sentence(const Report& report, const ReportTotals& t) {
  std::string text;
  if (t.over_grant > 0) text += host::counted(t.over_grant, "product") + " exceeded the byte grant. ";
  if (!report.missing.empty()) {
    text += host::counted(report.missing.size(), "part") + " of the downlink " +
            (report.missing.size() == 1 ? "has" : "have") + " not come: see below what and where. ";
  }
  if (t.files_skipped > 0) text += host::counted(t.files_skipped, "file") + " of the outbox could not be used. ";
  const std::size_t events = t.events_medium + t.events_high;
  if (events > 0) {
    text += host::counted(events, "event") + " of medium or high severity: see below what to do.";
  } else {
    text += "No event above low severity was reported.";
  }
  return text;
}

std::string tile(const std::string& what, const std::string& value, const std::string& how, const char* style = "") {
  return "<div class=\"tile\"><div class=\"what\">" + what + "</div><div class=\"value " + style + "\">" + value +
         "</div><div class=\"how\">" + how + "</div></div>\n";
}

std::string tiles_of(const AccuracySummary& accuracy, const std::string& whose) {
  constexpr const char* of_height = " <small>% of height flown</small>";
  std::string html;
  html += tile("Position error, mean" + whose, host::brief(accuracy.mean_percent) + " <small>% of distance</small>",
               "at most " + host::brief(accuracy.max_percent) + " %, " + host::counted(accuracy.poses, "pose"));
  if (std::isfinite(accuracy.height_percent))
    html += tile("Height error, median" + whose, host::brief(accuracy.height_percent) + of_height, "merged heights");
  if (std::isfinite(accuracy.depth_percent))
    html +=
        tile("Depth error, median" + whose, host::brief(accuracy.depth_percent) + of_height, "depths of single pixels");
  if (std::isfinite(accuracy.keyframe_depth_percent))
    html += tile("Depth error, median keyframe" + whose, host::brief(accuracy.keyframe_depth_percent) + of_height,
                 "each keyframe by its median pixel");
  return html;
}

std::string accuracy_tiles(const Report& report) {
  if (!report.has_reference && !report.score) return "";
  if (!model_is_measured(report)) return tiles_of(accuracy_of(report), "");
  const std::string model = tiles_of(measured_accuracy(report), ", joined model");
  return report.score ? model + tiles_of(scored_accuracy(*report.score), ", strips on board") : model;
}

/// What the flight itself says of its errors; without truth it is all there is.
std::string stated_tiles(const Report& report) {
  std::vector<double> positions, heights;
  std::string parts;
  for (const StripResult& strip : report.strips) {
    if (!(strip.flying_height > 0)) continue;
    for (const std::int64_t id : strip.strip.keyframes) {
      const intake::Keyframe& keyframe = report.flight.keyframes.at(id);
      if (!keyframe.posed()) continue;
      const double sigma = *std::max_element(std::begin(keyframe.pose->sigma), std::end(keyframe.pose->sigma));
      if (std::isfinite(sigma)) positions.push_back(100 * sigma / strip.flying_height);
    }
    if (!strip.grid) continue;
    for (const float sigma : strip.grid->estimated_sigma().samples) {
      if (std::isfinite(sigma)) heights.push_back(100 * sigma / strip.flying_height);
    }
    if (parts.empty()) parts = parts_text(strip.usual_errors, 100 / strip.flying_height);
  }
  std::string html;
  if (!positions.empty()) {
    html += tile("Position, estimated 1 σ",
                 host::brief(host::percentile(positions, 0.5)) + " <small>% of height flown</small>",
                 "median of the keyframes; at most " + host::brief(host::percentile(positions, 1)) + " %");
  }
  if (!heights.empty()) {
    html += tile("Heights, estimated 1 σ",
                 host::brief(host::percentile(heights, 0.5)) + " <small>% of height flown</small>",
                 "median of the map; 95 % below " + host::brief(host::percentile(heights, 0.95)) + " %; of " + parts);
  }
  return html;
}

std::string area_tile(const Report& report) {
  const StripResult* largest = nullptr;
  std::size_t maps = 0;
  for (const StripResult& strip : report.strips) {
    if (!strip.grid) continue;
    ++maps;
    if (largest == nullptr || strip.map.covered_area > largest->map.covered_area) largest = &strip;
  }
  if (largest == nullptr) return "";
  const auto [factor, unit] = length_unit(report, *largest);
  const std::string how = "in cells of " + host::brief(factor * largest->geometry.cell) + " " + unit;
  return tile("Ground mapped",
              host::brief(factor * factor * largest->map.covered_area) + " <small>square " + unit + "</small>",
              maps == 1 ? how : how + "; the largest of " + std::to_string(maps) + " maps");
}

std::string cost_tiles(const Report& report, const ReportTotals& t) {
  std::string html;
  const double bpp = t.product_pixels > 0 ? 8.0 * static_cast<double>(t.product_bytes) / t.product_pixels : unknown;
  html += tile("Downlinked products", host::bytes_text(t.product_bytes),
               host::counted(t.products, "file") + ", " + host::brief(bpp) + " bit per keyframe pixel");
  const auto keyframes = static_cast<double>(t.keyframes);
  if (report.info && t.keyframes > 0 && (report.info->flight_cpu_s || report.info->cpu_s)) {
    const double cpu = report.info->flight_cpu_s.value_or(report.info->cpu_s.value_or(unknown));
    html += tile("Processor per keyframe", host::duration_text(cpu / keyframes), host::duration_text(cpu) + " in all");
  }
  if (report.info && (report.info->static_bytes || report.info->peak_rss_mib)) {
    const bool both = report.info->static_bytes && report.info->peak_rss_mib;
    const double mib = report.info->static_bytes ? *report.info->static_bytes / 1048576 : *report.info->peak_rss_mib;
    html +=
        tile(report.info->static_bytes ? "Static memory" : "Peak memory", host::fixed(mib, 1) + " <small>MiB</small>",
             both ? "process peak " + host::fixed(*report.info->peak_rss_mib, 0) + " MiB"
                  : host::escaped(report.info->profile));
  }
  return html;
}

std::string calibration_words(const intake::Flight& flight) {
  if (!flight.camera_record || flight.calibrations.empty()) return "";
  const CameraRecord& camera = *flight.camera_record;
  if (!camera.frozen) return " (nominal: the camera was not known and could not be calibrated)";
  if (camera.source == CameraSource::given) return "";
  if (camera.source == CameraSource::nominal)
    return " ± " + host::brief(camera.sigma_focal_px) + " px (nominal: the images did not determine it)";
  return " ± " + host::brief(camera.sigma_focal_px) + " px (found in flight, at keyframe " +
         std::to_string(flight.calibrations.rbegin()->first) + ")";
}

std::string readout_words(const intake::Flight& flight) {
  if (!flight.camera_record || !has_rolling_shutter(*flight.camera_record)) return "";
  const CameraRecord& camera = *flight.camera_record;
  const std::string time = ", rolling shutter of " + host::brief(1e3 * camera.readout_s);
  if (!(camera.sigma_readout_s > 0)) return time + " ms";
  return time + " ± " + host::brief(1e3 * camera.sigma_readout_s) + " ms (found in flight)";
}

std::string subtitle(const Report& report) {
  std::string text;
  const auto add = [&text](const std::string& part) {
    if (!part.empty()) text += (text.empty() ? "" : " · ") + part;
  };
  if (report.info) {
    add(host::escaped(report.info->source));
    if (report.info->frames) add(host::fixed(*report.info->frames, 0) + " frames");
  }
  if (report.flight.camera) {
    const CameraModel& c = *report.flight.camera;
    add("camera " + std::to_string(c.width) + " × " + std::to_string(c.height) + ", focal length " + host::brief(c.fx) +
        " px" + calibration_words(report.flight) + readout_words(report.flight));
  }
  if (report.info) {
    add(report.info->software.empty() ? "" : "software " + host::escaped(report.info->software));
    add(report.info->profile.empty() ? "" : "profile " + host::escaped(report.info->profile));
    if (report.info->seed) add("seed " + host::fixed(*report.info->seed, 0));
  }
  return text;
}

std::string viewer_link(const Report& report) {
  return report.has_viewer ? "<div><a href=\"viewer.html\">Look at the flight in 3D</a></div>" : "";
}

}  // namespace

std::string cell(const std::string& html, const char* style) {
  return (*style == '\0' ? std::string("<td>") : std::string("<td class=\"") + style + "\">") + html + "</td>";
}

std::string page_summary(const Report& report) {
  const ReportTotals t = totals(report);
  std::string html = "<header><p class=\"kicker\">Aerobot imaging and localization: flight report</p><h1>" +
                     host::escaped(report.title) + "</h1><div class=\"sub\">" + subtitle(report) + "</div>" +
                     viewer_link(report) + "</header>\n";
  for (const std::string& line : nothing_lines(report)) html += "<p class=\"bad\">" + host::escaped(line) + "</p>\n";
  for (const std::string& line : camera_lines(report.flight))
    html += "<p class=\"warn\">" + host::escaped(line) + "</p>\n";
  html += "<p class=\"lede\">" + coverage_sentence(report, t) + accuracy_sentence(report) +
          trouble_sentence(report, t) + "</p>\n";
  html += "<div class=\"tiles\">\n";
  const bool all = t.posed == t.keyframes && t.keyframes > 0;
  html += tile("Keyframes with final pose",
               std::to_string(t.posed) + " <small>of " + std::to_string(t.keyframes) + "</small>",
               host::counted(report.strips.size(), "strip") + ", " + std::to_string(t.with_depth) + " with depth",
               t.posed == 0 ? "bad"
               : all        ? "good"
                            : "warn");
  html += area_tile(report) + accuracy_tiles(report) + stated_tiles(report) + cost_tiles(report, t);
  const std::size_t events = t.events_medium + t.events_high;
  html += tile("Events of medium or high severity", std::to_string(events),
               host::counted(report.flight.events.size(), "event") + " in all",
               t.events_high > 0 ? "bad"
               : events > 0      ? "warn"
                                 : "good");
  return html + "</div>\n";
}

}  // namespace ilp::report
