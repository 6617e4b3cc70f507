#include <ostream>

#include "sim/ground/report/json_writer.hpp"
#include "sim/ground/report/map_pictures.hpp"
#include "sim/ground/report/page.hpp"
#include "sim/ground/report/page_resource.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

/// What is not in report.json: figures by name, and the pictures of the keyframes.
void write_pictures(const Report& report, std::ostream& out) {
  JsonWriter json(out, JsonStyle::compact);
  json.begin_object("figures");
  map_figures(
      report, [](const std::string&, const std::vector<std::uint8_t>& png) { return host::data_uri(png); },
      [&json](const std::string& name, const Json& figure) { json.put(name, figure); });
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
void write_page(const std::string& title, const std::string& without_script, std::initializer_list<PageData> data,
                std::ostream& out) {
  out << "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
         "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline'; "
         "style-src 'unsafe-inline'; img-src data:\">"
         "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><title>"
      << host::escaped(title) << "</title><style>" << page_style() << "</style></head>\n<body><main>\n<noscript><p>"
      << "This page is drawn with JavaScript, which is switched off here. " << without_script
      << "</p></noscript></main>\n";
  for (const PageData& one : data) {
    out << "<script type=\"application/json\" id=\"" << one.name << "\">";
    one.write(out);
    out << "</script>\n";
  }
  out << "<script type=\"module\">" << page_script() << "</script>\n</body></html>\n";
}

void write_report_html(const Report& report, std::ostream& out) {
  write_page(report.title,
             "<code>report.json</code> beside it has all its figures; the last lines of <code>ilp-ground</code> in the "
             "terminal have the most important.",
             {{"report", [&](std::ostream& to) { write_report_json(report, to, JsonStyle::compact); }},
              {"pictures", [&](std::ostream& to) { write_pictures(report, to); }}},
             out);
}

}  // namespace ilp::report
