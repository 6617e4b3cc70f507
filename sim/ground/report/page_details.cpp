// Events and what to do, plots, cost, files.
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/report/page_sections.hpp"
#include "sim/host/status_error.hpp"
#include "sim/host/svg_plot.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

struct EventGroup {
  std::vector<const EventRecord*> events;
};

const char* severity_style(std::uint8_t severity) {
  return severity >= static_cast<std::uint8_t>(Severity::high)     ? "bad"
         : severity == static_cast<std::uint8_t>(Severity::medium) ? "warn"
                                                                   : "sub";
}

std::string chip(std::uint8_t severity) {
  return std::string("<span class=\"chip ") + severity_style(severity) + "\">" + host::severity_name(severity) +
         "</span>";
}

std::string mission_time(TimeNs time) {
  return host::fixed(static_cast<double>(time) / 1e9, 1) + " s";
}

std::string group_row(const std::vector<const EventRecord*>& events) {
  const EventRecord& first = *events.front();
  std::string sentence = host::escaped(host::event_sentence(first));
  if (events.size() > 1) sentence += " <span class=\"sub\">(the first of " + std::to_string(events.size()) + ")</span>";
  return "<tr>" + cell(chip(first.severity), "t") + cell(std::to_string(events.size())) +
         cell(mission_time(first.time_ns)) + cell(host::escaped(first.component), "t") + cell(sentence, "t w") +
         cell(host::escaped(host::event_advice(first.code)), "t w") + "</tr>\n";
}

std::string every_event(const std::vector<EventRecord>& events) {
  std::string html =
      "<details><summary>" + host::counted(events.size(), "event") +
      " in order</summary><div class=\"scroll\"><table>"
      "<tr><th>time</th><th class=\"t\">severity</th><th class=\"t\">component</th><th class=\"t\">event</th></tr>\n";
  for (const EventRecord& e : events) {
    html += "<tr>" + cell(mission_time(e.time_ns)) + cell(host::severity_name(e.severity), "t") +
            cell(host::escaped(e.component), "t") +
            cell(host::escaped(host::event_sentence(e)) +
                     (e.place[0] == '\0' ? "" : " <span class=\"sub\">" + host::escaped(e.place) + "</span>"),
                 "t w") +
            "</tr>\n";
  }
  return html + "</table></div></details>\n";
}

// Without the onboard database only the keyframes' own frames are known.
host::Plot overlap_plot(const Report& report) {
  host::Plot plot;
  plot.title = "Overlap with the latest keyframe";
  plot.x_label = "frame";
  plot.y_label = "%";
  if (std::isfinite(report.target_overlap)) plot.target = 100 * report.target_overlap;
  plot.target_name = "target";
  plot.from_zero = false;
  host::PlotSeries frames{"frames", "s1", host::Mark::dots, {}}, keyframes{"keyframes", "s2", host::Mark::dots, {}};
  std::map<std::int64_t, bool> is_keyframe;
  for (const auto& [id, k] : report.flight.keyframes) {
    if (!k.record) continue;
    is_keyframe[k.record->frame_id] = true;
    if (k.record->index > 0) {
      keyframes.points.emplace_back(static_cast<double>(k.record->frame_id), 100 * k.record->overlap);
    }
  }
  for (const auto& [id, overlap] : report.flight.overlaps) {
    if (overlap.keyframe_id > 0 && overlap.verdict == OverlapVerdict::ok && !is_keyframe.contains(id)) {
      frames.points.emplace_back(static_cast<double>(id), 100 * overlap.overlap);
    }
  }
  plot.series = {frames, keyframes};
  return plot;
}

template <typename Value>
host::PlotSeries per_keyframe(const Report& report, const char* name, const char* style, host::Mark mark, Value value) {
  host::PlotSeries series{name, style, mark, {}};
  for (const auto& [id, keyframe] : report.flight.keyframes) {
    const double y = value(keyframe);
    if (std::isfinite(y)) series.points.emplace_back(static_cast<double>(id), y);
  }
  return series;
}

host::Plot richness_plot(const Report& report) {
  host::Plot plot;
  plot.title = "Image Richness Index and novelty";
  plot.x_label = "keyframe";
  plot.y_label = "0 to 1";
  plot.series = {per_keyframe(report, "richness", "s1", host::Mark::line,
                              [](const intake::Keyframe& k) { return k.richness ? k.richness->richness : unknown; }),
                 per_keyframe(report, "novelty", "s2", host::Mark::line,
                              [](const intake::Keyframe& k) { return k.richness ? k.richness->novelty : unknown; })};
  return plot;
}

host::Plot rms_plot(const Report& report) {
  host::Plot plot;
  plot.title = "Reprojection error of the adjustment window";
  plot.x_label = "keyframe";
  plot.y_label = "px";
  plot.series = {per_keyframe(report, "rms", "s1", host::Mark::line, [](const intake::Keyframe& k) {
    return k.pose && k.pose->matches > 0 ? k.pose->rms_px : unknown;
  })};
  return plot;
}

host::Plot bytes_plot(const Report& report) {
  host::Plot plot;
  plot.title = "Bytes of the products";
  plot.x_label = "keyframe";
  plot.y_label = "kB";
  const auto kilobytes = [](ProductKind kind) {
    return [kind](const intake::Keyframe& k) {
      return k.product(kind) ? static_cast<double>(k.product(kind)->bytes) / 1e3 : unknown;
    };
  };
  plot.series = {per_keyframe(report, "image", "s1", host::Mark::bars, kilobytes(ProductKind::image)),
                 per_keyframe(report, "depth", "s3", host::Mark::bars, kilobytes(ProductKind::depth))};
  return plot;
}

host::Plot error_plot(const Report& report) {
  host::Plot plot;
  plot.title = "Errors against the reference";
  plot.x_label = "keyframe";
  plot.y_label = "%";
  host::PlotSeries position{"position, of distance", "s2", host::Mark::line, {}},
      height{"height, of height flown", "s3", host::Mark::line, {}};
  for (const StripResult& strip : report.strips) {
    if (!strip.accuracy) continue;
    for (const auto& [id, a] : strip.accuracy->keyframes) {
      position.points.emplace_back(static_cast<double>(id), strip.accuracy->percent_of_length(a.position));
      if (a.depth) height.points.emplace_back(static_cast<double>(id), a.depth->median_abs_percent);
    }
  }
  plot.series = {position};
  if (!height.points.empty()) plot.series.push_back(height);
  return plot;
}

using OfHousekeeping = std::function<double(const intake::HousekeepingReport&)>;

host::PlotSeries per_report(const Report& report, const char* name, const char* style, const OfHousekeeping& value) {
  host::PlotSeries series{name, style, host::Mark::line, {}};
  double number = 0;
  for (const intake::HousekeepingReport& r : report.flight.housekeeping) series.points.emplace_back(++number, value(r));
  return series;
}

host::Plot housekeeping_plot(const char* title, const char* unit, std::vector<host::PlotSeries> series) {
  host::Plot plot;
  plot.title = title;
  plot.x_label = "housekeeping report";
  plot.y_label = unit;
  plot.series = std::move(series);
  return plot;
}

/// Empty where fewer reports came than make a line.
std::string housekeeping_plots(const Report& report) {
  using R = const intake::HousekeepingReport&;
  if (report.flight.housekeeping.size() < 3) return "";
  const auto megabytes = [](std::int64_t bytes) { return 1e-6 * static_cast<double>(bytes); };
  const auto held = housekeeping_plot(
      "Data held on board", "MB",
      {per_report(report, "frames", "s1", [&](R r) { return megabytes(r.storage.frame_bytes); }),
       per_report(report, "depth", "s2", [&](R r) { return megabytes(r.storage.depth_bytes); }),
       per_report(report, "products", "s3", [&](R r) { return megabytes(r.storage.product_bytes); })});
  const auto database = housekeeping_plot(
      "Database on board", "MB",
      {per_report(report, "file", "s1", [&](R r) { return megabytes(r.storage.database_bytes); }),
       per_report(report, "unused", "s2", [&](R r) { return megabytes(r.storage.database_free_bytes); })});
  const auto busy =
      housekeeping_plot("Processor time of the components", "s since the start",
                        {per_report(report, "all", "s1", [](R r) { return 1e-9 * static_cast<double>(r.busy_ns); })});
  return "<div class=\"plots\">\n" + host::svg_plot(held) + "\n" + host::svg_plot(database) + "\n" +
         host::svg_plot(busy) + "\n</div>\n";
}

std::string component_table(const Report& report) {
  std::string html =
      "<div class=\"scroll\"><table><tr><th class=\"t\">component</th><th>steps</th><th>processor time</th>"
      "<th>share</th><th>per keyframe</th><th>longest "
      "step</th><th>overruns</th><th>faults</th><th>restarts</th></tr>\n";
  double all = 0;
  for (const ComponentRecord& c : report.flight.components) all += static_cast<double>(c.busy_ns);
  const auto keyframes = static_cast<double>(std::max<std::size_t>(1, report.flight.keyframes.size()));
  for (const ComponentRecord& c : report.flight.components) {
    const auto busy = static_cast<double>(c.busy_ns);
    const auto count = [](std::uint32_t n) { return cell(std::to_string(n), n > 0 ? "warn" : ""); };
    html += "<tr>" + cell(host::escaped(c.name), "t") + cell(std::to_string(c.steps)) +
            cell(host::duration_text(busy / 1e9)) + cell(all > 0 ? host::fixed(100 * busy / all, 0) + " %" : "–") +
            cell(host::duration_text(busy / 1e9 / keyframes)) +
            cell(host::duration_text(static_cast<double>(c.longest_ns) / 1e9)) + count(c.overruns) + count(c.faults) +
            count(c.restarts) + "</tr>\n";
  }
  return html + "</table></div>\n";
}

host::Plot timing_plot(const TimingRecord& timing) {
  host::Plot plot;
  plot.title = "Minor frames: late begins and lengths";
  plot.x_label = "below 2^x microseconds";
  plot.y_label = "log10(1 + frames)";
  host::PlotSeries late{"late", "s2", host::Mark::bars, {}}, used{"length", "s1", host::Mark::bars, {}};
  for (std::size_t bin = 0; bin < limits::timing_bins; ++bin) {
    const auto x = static_cast<double>(bin);
    late.points.emplace_back(x, std::log10(1.0 + timing.late[bin]));
    used.points.emplace_back(x, std::log10(1.0 + timing.used[bin]));
  }
  plot.series = {late, used};
  return plot;
}

std::string timing_section(const Report& report) {
  if (!report.flight.timing) return "";
  const TimingRecord& t = *report.flight.timing;
  std::size_t reduced = 0;
  for (const auto& [id, k] : report.flight.keyframes) reduced += k.record && k.record->degraded > 0 ? 1 : 0;
  std::string html = "<p>" + std::to_string(t.frames) + " minor frames, " + std::to_string(t.overruns) +
                     " ended late; the longest took " + host::duration_text(1e-9 * static_cast<double>(t.longest_ns)) +
                     ", the latest began " + host::duration_text(1e-9 * static_cast<double>(t.latest_ns)) +
                     " behind its time. Work was reduced or restored " + std::to_string(t.degraded_changes) +
                     " times; " + host::counted(reduced, "keyframe") + " computed at a reduced level.</p>\n";
  // In virtual time nothing takes mission time: nothing to see.
  if (t.longest_ns == 0 && t.latest_ns == 0) return html;
  return html + "<div class=\"plots\">\n" + host::svg_plot(timing_plot(t)) + "\n</div>\n";
}

std::string memory_sentence(const Report& report) {
  std::string text;
  if (report.info) {
    const intake::FlightInfo& i = *report.info;
    if (i.static_bytes)
      text += "Static memory of the flight software " + host::fixed(*i.static_bytes / 1048576, 1) + " MiB. ";
    if (i.peak_rss_mib) text += "The process took " + host::fixed(*i.peak_rss_mib, 0) + " MiB at most. ";
    if (i.wall_s) text += "The run took " + host::duration_text(*i.wall_s) + " on the host. ";
  }
  if (const auto& s = report.flight.storage) {
    text +=
        "Onboard storage: " + host::bytes_text(static_cast<std::uint64_t>(std::max<std::int64_t>(0, s->frame_bytes))) +
        " of frames, " + host::bytes_text(static_cast<std::uint64_t>(std::max<std::int64_t>(0, s->depth_bytes))) +
        " of depth, " + host::bytes_text(static_cast<std::uint64_t>(std::max<std::int64_t>(0, s->product_bytes))) +
        " of products, of " + host::bytes_text(static_cast<std::uint64_t>(std::max<std::int64_t>(0, s->budget_bytes))) +
        " allowed; " + host::counted(s->products_dropped, "product") + " dropped. ";
  }
  return text;
}

std::string place_of(const Report& report, const intake::Missing& missing) {
  if (!missing.centre) return "–";
  const auto strip = report.flight.strips.find(missing.strip_id);
  std::string text = "strip " + std::to_string(missing.strip_id) + ", x " + host::brief(missing.centre->x()) + ", y " +
                     host::brief(missing.centre->y());
  if (strip != report.flight.strips.end()) text += std::string(" ") + intake::unit_of(report.flight, strip->second);
  return text;
}

std::string missing_list(const Report& report) {
  if (report.missing.empty()) return "";
  std::string html = "<h3>What has not come down</h3>\n<details" +
                     std::string(report.missing.size() <= 12 ? " open" : "") + "><summary>" +
                     host::counted(report.missing.size(), "thing") +
                     "</summary><div class=\"scroll\"><table><tr><th>keyframe</th><th class=\"t\">missing</th>"
                     "<th class=\"t\">where</th></tr>\n";
  for (const intake::Missing& missing : report.missing) {
    html += "<tr>" + cell(std::to_string(missing.keyframe_id)) + cell(host::escaped(missing.what), "t") +
            cell(host::escaped(place_of(report, missing)), "t") + "</tr>\n";
  }
  return html +
         "</table></div></details>\n<p class=\"note\">It may still be on its way, or have been abandoned on "
         "board. The same products again make the map more complete: run this command again.</p>\n";
}

std::string notes_of_images(const Report& report) {
  if (!report.info || report.info->notes.empty()) return "";
  std::string html = "<h3>What was said of the images and measurements before the flight</h3>\n<ul>\n";
  for (const std::string& note : report.info->notes) html += "<li>" + host::escaped(note) + "</li>\n";
  return html + "</ul>\n";
}

}  // namespace

std::string page_problems(const Report& report) {
  std::string html = "<h2>What went wrong, and what to do</h2>\n" + notes_of_images(report);
  std::map<std::pair<int, std::uint16_t>, std::vector<const EventRecord*>> groups;
  for (const EventRecord& event : report.flight.events) groups[{-event.severity, event.code}].push_back(&event);
  if (groups.empty()) html += "<p class=\"note\">No events came down.</p>\n";
  if (!groups.empty()) {
    html +=
        "<div class=\"scroll\"><table><tr><th class=\"t\">severity</th><th>times</th><th>first</th><th "
        "class=\"t\">component</th>"
        "<th class=\"t\">what happened</th><th class=\"t\">what to do</th></tr>\n";
    for (const auto& [key, events] : groups) html += group_row(events);
    html += "</table></div>\n" + every_event(report.flight.events);
  }
  html += missing_list(report);
  if (!report.flight.remarks.empty()) {
    html += "<h3>Found on the ground</h3><ul>";
    for (const std::string& remark : report.flight.remarks) html += "<li>" + host::escaped(remark) + "</li>";
    html += "</ul>\n";
  }
  return html;
}

std::string page_plots(const Report& report) {
  std::string html = "<h2>Along the flight</h2>\n<div class=\"plots\">\n" + host::svg_plot(overlap_plot(report)) +
                     "\n" + host::svg_plot(richness_plot(report)) + "\n" + host::svg_plot(rms_plot(report)) + "\n" +
                     host::svg_plot(bytes_plot(report)) + "\n";
  if (report.has_reference) html += host::svg_plot(error_plot(report)) + "\n";
  return html + "</div>\n";
}

std::string page_cost(const Report& report) {
  std::string html = "<h2>What it cost</h2>\n";
  const std::string memory = memory_sentence(report);
  if (!memory.empty()) html += "<p>" + memory + "</p>\n";
  if (report.flight.components.empty()) return html + "<p class=\"note\">No component housekeeping came down.</p>\n";
  return html + component_table(report) + timing_section(report) + housekeeping_plots(report);
}

std::string page_files(const Report& report) {
  const ReportTotals t = totals(report);
  std::string html = "<h2>Files received</h2>\n<p>" + host::counted(t.files_used, "file") + " with " +
                     host::bytes_text(t.received_bytes) + " used, " + std::to_string(t.files_skipped) +
                     " skipped.</p>\n";
  if (t.files_skipped == 0) return html;
  html += "<div class=\"scroll\"><table><tr><th class=\"t\">skipped</th><th>size</th><th class=\"t\">why</th></tr>\n";
  for (const intake::ReceivedFile& file : report.outbox.files) {
    if (file.fault.empty()) continue;
    html += "<tr>" + cell(host::escaped(file.name), "t w") + cell(host::bytes_text(file.bytes)) +
            cell(host::escaped(file.fault), "t w") + "</tr>\n";
  }
  return html + "</table></div>\n";
}

}  // namespace ilp::report
