#include "sim/ground/viewer/viewer_page.hpp"

#include <functional>
#include <sstream>

#include "sim/ground/report/json_writer.hpp"
#include "sim/ground/viewer/resource.hpp"
#include "sim/ground/viewer/viewer_data.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::viewer {
namespace {

// The policy blocks all outside content, whatever the data contain.
void write_page(const std::string& title, const std::function<void(std::ostream&)>& write_report,
                const std::function<void(report::JsonWriter&)>& put_flight, const std::string& without_script,
                std::ostream& out) {
  out << "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
         "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline'; "
         "style-src 'unsafe-inline'; img-src data: blob:\">"
         "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><title>"
      << host::escaped(title) << " – viewer</title><link rel=\"icon\" href=\"data:,\"><style>" << style()
      << "</style></head>\n<body><div id=\"app\"><noscript><p>" << without_script << "</p></noscript></div>\n"
      << "<script type=\"application/json\" id=\"report\">";
  write_report(out);
  out << "</script>\n<script type=\"application/json\" id=\"flight\">";
  report::JsonWriter flight(out, report::JsonStyle::compact);
  put_flight(flight);
  flight.end();
  out << "</script>\n<script type=\"text/plain\" id=\"licence\">" << licence() << "</script>\n<script>" << script()
      << "</script>\n</body></html>\n";
}

void put_flight(const report::Report& report, report::JsonWriter& json) {
  json.begin_list("strips");
  for (const report::StripResult& strip : report.strips) json.add(viewer_strip(report, strip));
  json.end_list();
  json.begin_list("keyframes");
  for (const auto& [id, keyframe] : report.flight.keyframes) json.add(viewer_keyframe(report, keyframe));
  json.end_list();
  json.put("links", viewer_links(report.flight));
  json.put("downlink", viewer_downlink(report));
}

}  // namespace

bool viewer_available() {
  return !script().empty();
}

void write_viewer_html(const report::Report& report, std::ostream& out) {
  write_page(
      report.title, [&](std::ostream& page) { write_report_json(report, page, report::JsonStyle::compact); },
      [&](report::JsonWriter& flight) { put_flight(report, flight); },
      "This page draws with JavaScript, which is switched off here. The pictures are in report.html.", out);
}

std::string viewer_empty_html(const std::string& title, const std::string& reason) {
  std::ostringstream page;
  write_page(
      title, [](std::ostream& out) { out << "null"; },
      [&](report::JsonWriter& flight) {
        flight.put("title", title);
        flight.put("nothing", reason);
      },
      host::escaped(reason), page);
  return std::move(page).str();
}

}  // namespace ilp::viewer
