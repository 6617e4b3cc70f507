#include <ostream>

#include "sim/ground/report/figures.hpp"
#include "sim/ground/report/json_writer.hpp"
#include "sim/ground/report/map_figures.hpp"
#include "sim/ground/report/page_resource.hpp"
#include "sim/host/picture.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

/// What is not in report.json: figures by name, and the pictures of the keyframes.
void write_pictures(const Report& report, std::ostream& out) {
  JsonWriter json(out, JsonStyle::compact);
  json.begin_object("figures");
  const auto put = [&json](const std::string& name, const std::vector<std::string>& figures) {
    json.put(name, figures);
  };
  for (const StripResult& strip : report.strips) {
    const std::string id = std::to_string(strip.strip.id);
    if (strip.posed > 0) put("strip " + id, figures_of_strip(report.flight, strip));
    if (strip.landing && strip.landing->map) put("landing " + id, {figure_of_landing(report.flight, strip)});
  }
  for (const fixes::StripFixes& strip : report.fixes.strips)
    put("fixes " + std::to_string(strip.strip_id), {figure_of_fixes(report, strip)});
  if (report.score) put("height errors", {figure_of_height_errors(*report.score)});
  json.end_object();
  json.begin_object("keyframes");
  for (const auto& [id, keyframe] : report.flight.keyframes) {
    const map::KeyframeQuickLook look = look_of(report, id);
    Json pictures = Json::object();
    const auto add = [&](const char* name, const std::vector<std::uint8_t>& png) {
      if (!png.empty()) pictures[name] = host::data_uri(png);
    };
    add("image", look.image);
    add("depth", look.depth);
    add("mask", look.mask);
    json.put(std::to_string(id), pictures);
  }
  json.end_object();
  json.end();
}

}  // namespace

// The policy blocks all outside content, whatever the data contain.
std::string begin_page(const std::string& title) {
  return "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
         "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline'; "
         "style-src 'unsafe-inline'; img-src data:\">"
         "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><title>" +
         host::escaped(title) + "</title><style>" + std::string(page_style()) + "</style></head>\n<body><main>\n";
}

void write_report_html(const Report& report, std::ostream& out) {
  out << begin_page(report.title)
      << "<noscript><p>This page is drawn with JavaScript, which is switched off here. <code>report.json</code> beside "
         "it has all its figures; the last lines of <code>ilp-ground</code> in the terminal have the most "
         "important.</p>"
         "</noscript></main>\n<script type=\"application/json\" id=\"report\">";
  write_report_json(report, out, JsonStyle::compact);
  out << "</script>\n<script type=\"application/json\" id=\"pictures\">";
  write_pictures(report, out);
  out << "</script>\n<script type=\"module\">" << page_script() << "</script>\n</body></html>\n";
}

}  // namespace ilp::report
