// When the images were taken: captures, their forecasts, telecommands.
#include <algorithm>
#include <cmath>

#include "sim/ground/report/capture_summary.hpp"
#include "sim/ground/report/page_sections.hpp"
#include "sim/host/svg_plot.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

constexpr std::size_t max_rows = 60;

void add_forecast(host::PlotSeries& series, double x, double value, double sigma) {
  series.points.emplace_back(x, 100 * value);
  // No overlap is further off than all of it.
  series.sigmas.push_back(100 * std::min(sigma, 1.0));
}

host::Plot keyframe_plot(const Report& report, const CaptureSummary& summary) {
  host::Plot plot;
  plot.title = "Overlap of each keyframe with the one before";
  plot.x_label = "keyframe";
  plot.y_label = "%";
  plot.from_zero = false;
  if (std::isfinite(report.target_overlap)) plot.target = 100 * report.target_overlap;
  plot.target_name = "target";
  host::PlotSeries forecast{"forecast, 1 sigma", "s1", host::Mark::dots, {}},
      measured{"measured", "s2", host::Mark::dots, {}};
  for (const ForecastCheck& check : summary.forecasts) {
    if (check.keyframe_id == 0) continue;
    add_forecast(forecast, static_cast<double>(check.keyframe_id), check.forecast, check.sigma);
  }
  for (const auto& [id, keyframe] : report.flight.keyframes) {
    if (!keyframe.record || keyframe.record->index <= 0) continue;
    const double overlap = keyframe.record->overlap;
    if (overlap >= 0 && overlap <= 1) measured.points.emplace_back(static_cast<double>(id), 100 * overlap);
  }
  plot.series = {forecast, measured};
  return plot;
}

host::Plot error_plot(const CaptureSummary& summary) {
  host::Plot plot;
  plot.title = "Forecast minus measured overlap";
  plot.x_label = "capture";
  plot.y_label = "%";
  plot.target = 0;
  for (std::size_t source = 0; source < capture_sources; ++source) {
    static constexpr const char* styles[] = {"s4", "s1", "s3", "s4", "s4", "s4", "s4"};
    static_assert(std::size(styles) == capture_sources);
    host::PlotSeries series{capture_source_words(source), styles[source], host::Mark::dots, {}};
    for (const ForecastCheck& check : summary.forecasts) {
      if (check.source != source) continue;
      add_forecast(series, static_cast<double>(check.capture_id), check.error(), check.sigma);
    }
    if (!series.points.empty()) plot.series.push_back(series);
  }
  return plot;
}

std::string count_table(const CaptureSummary& summary) {
  std::string html = "<div class=\"scroll\"><table><tr><th class=\"t\">captures</th><th>all</th>";
  for (std::size_t state = 0; state < capture_states; ++state) {
    if (summary.by_state[state] > 0) html += "<th>" + std::string(capture_state_words(state)) + "</th>";
  }
  html += "</tr>\n";
  for (std::size_t source = 0; source < capture_sources; ++source) {
    std::size_t all = 0;
    std::string cells;
    for (std::size_t state = 0; state < capture_states; ++state) {
      const std::size_t count = summary.counts[source][state];
      all += count;
      if (summary.by_state[state] > 0) cells += cell(std::to_string(count));
    }
    if (all > 0)
      html += "<tr>" + cell(capture_source_words(source), "t") + cell(std::to_string(all)) + cells + "</tr>\n";
  }
  return html + "</table></div>\n";
}

std::string signed_percent(double share) {
  return (share > 0 ? "+" : "") + host::fixed(100 * share, 1) + " %";
}

std::string summary_sentence(const Report& report, const CaptureSummary& s) {
  std::string text;
  if (std::isfinite(s.frames_per_keyframe)) text += host::brief(s.frames_per_keyframe) + " frames per keyframe. ";
  if (s.achieved.count > 0) {
    text += "Achieved minus target overlap is " + signed_percent(s.achieved.mean) + ", target " +
            host::fixed(100 * report.target_overlap, 0) + " % (mean of " + host::counted(s.achieved.count, "keyframe") +
            "; standard deviation " + host::fixed(100 * s.achieved.deviation, 1) + " %). ";
  }
  if (s.forecast_error.count > 0) {
    text += "Forecast minus measured overlap is " + signed_percent(s.forecast_error.mean) + " (mean of " +
            host::counted(s.forecast_error.count, "capture") + "; standard deviation " +
            host::fixed(100 * s.forecast_error.deviation, 1) + " %). ";
  }
  if (s.with_sigma > 0) {
    text += "Inside 1 sigma lie " + host::fixed(100 * s.within_1_sigma, 0) + " % of the forecasts and inside 2 sigma " +
            host::fixed(100 * s.within_2_sigma, 0) + " %; 68 % and 95 % would be honest. ";
  }
  if (s.forecasts_unchecked > 0) {
    text += host::counted(s.forecasts_unchecked, "forecast") +
            " cannot be checked: the overlap was not measured, or against another keyframe. ";
  }
  return text.empty() ? "" : "<p>" + text + "</p>\n";
}

bool is_listed(const CaptureRecord& capture) {
  return is_telecommanded(capture) || capture.state == CaptureState::no_frame ||
         capture.state == CaptureState::rejected;
}

// In order of ids; where there are too many, those without a frame go before the others.
std::vector<const CaptureRecord*> listed_captures(const intake::Flight& flight, std::size_t& all) {
  std::vector<const CaptureRecord*> listed;
  for (const auto& [id, capture] : flight.captures) {
    if (is_listed(capture)) listed.push_back(&capture);
  }
  all = listed.size();
  if (all <= max_rows) return listed;
  std::stable_partition(listed.begin(), listed.end(),
                        [](const CaptureRecord* capture) { return capture->state != CaptureState::exposed; });
  listed.resize(max_rows);
  std::sort(listed.begin(), listed.end(), [](const auto* a, const auto* b) { return a->id < b->id; });
  return listed;
}

std::string seconds(TimeNs time) {
  return host::fixed(static_cast<double>(time) / 1e9, 3);
}

std::string capture_row(const intake::Flight& flight, const CaptureRecord& capture) {
  const bool exposed = capture.state == CaptureState::exposed;
  const bool lost = capture.state == CaptureState::no_frame || capture.state == CaptureState::rejected;
  return "<tr>" + cell(std::to_string(capture.id)) + cell(capture_source_words(source_index(capture)), "t") +
         cell(seconds(capture.requested_ns)) + cell(exposed ? seconds(capture.exposed_ns) : "–") +
         cell(host::fixed(exposure_delay_ms(capture), 1)) + cell(exposed ? std::to_string(capture.frame_id) : "–") +
         cell(capture_state_words(state_index(capture)), lost ? "t warn" : "t") +
         cell(host::escaped(capture_reason(flight, capture)), "t w") + "</tr>\n";
}

std::string capture_table(const intake::Flight& flight) {
  std::size_t all = 0;
  const std::vector<const CaptureRecord*> listed = listed_captures(flight, all);
  if (listed.empty()) return "<p class=\"note\">No capture was telecommanded, and none stayed without a frame.</p>\n";
  std::string html = "<h3>Telecommanded captures, and those without a frame</h3>\n";
  if (listed.size() < all) {
    html += "<p class=\"note\">" + std::to_string(listed.size()) + " of " + std::to_string(all) +
            " shown, those without a frame before the others; <code>report.json</code> has all.</p>\n";
  }
  html +=
      "<div class=\"scroll\"><table><tr><th>capture</th><th class=\"t\">source</th><th>wanted, s</th>"
      "<th>exposed, s</th><th>difference, ms</th><th>frame</th><th class=\"t\">state</th>"
      "<th class=\"t\">why</th></tr>\n";
  for (const CaptureRecord* capture : listed) html += capture_row(flight, *capture);
  return html + "</table></div>\n";
}

}  // namespace

std::string page_captures(const Report& report) {
  if (report.flight.captures.empty()) return "";
  const CaptureSummary summary = summarise_captures(report.flight, report.target_overlap);
  std::string html = "<h2>When the images were taken</h2>\n" + summary_sentence(report, summary);
  html += "<div class=\"plots\">\n" + host::svg_plot(keyframe_plot(report, summary)) + "\n";
  if (!summary.forecasts.empty()) html += host::svg_plot(error_plot(summary)) + "\n";
  return html + "</div>\n<h3>Captures by what asked for them</h3>\n" + count_table(summary) +
         capture_table(report.flight);
}

}  // namespace ilp::report
