#include <ostream>

#include "sim/ground/report/figures.hpp"
#include "sim/ground/report/page_sections.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

// The page's style sheet: no fonts, no scripts, nothing from outside; light and dark.

inline constexpr const char* report_style = R"css(
:root{color-scheme:light dark;--page:#fbfaf8;--card:#fff;--ink:#1d232b;--muted:#59626d;--line:#e3e1dc;--accent:#a8481f;
--s1:#2b6aa3;--s2:#c8762b;--s3:#4b8a57;--s4:#8a5a9c;--good:#276c3f;--warn:#855300;--bad:#b3261e;--plate:#eceae5}
@media (prefers-color-scheme:dark){:root{--page:#14171b;--card:#1b1f25;--ink:#e4e7eb;--muted:#98a2ae;--line:#2d333b;
--accent:#e58a5c;--s1:#6fb0e6;--s2:#eaa45e;--s3:#7fc48d;--s4:#c193d4;--good:#74c690;--warn:#e0b050;--bad:#f08a80;
--plate:#23282f}}
*{box-sizing:border-box}
body{margin:0;background:var(--page);color:var(--ink);font:15px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,"Helvetica Neue",sans-serif}
main{max-width:1180px;margin:0 auto;padding:36px 24px 64px}
header{border-bottom:2px solid var(--ink);padding-bottom:18px;margin-bottom:22px}
.kicker{color:var(--accent);font-size:12px;letter-spacing:.12em;text-transform:uppercase;margin:0 0 4px}
a{color:var(--accent)}
h1{font-size:30px;line-height:1.2;margin:0 0 6px;font-weight:650;letter-spacing:-.01em;overflow-wrap:anywhere}
h2{font-size:19px;margin:44px 0 10px;font-weight:650;letter-spacing:-.005em}
h3{font-size:15px;margin:22px 0 8px;font-weight:600}
p{margin:0 0 10px;max-width:76ch}
.sub,.note,figcaption{color:var(--muted);font-size:13px}
.lede{font-size:17px;line-height:1.55;max-width:78ch}
.tiles{display:grid;grid-template-columns:repeat(auto-fit,minmax(190px,1fr));gap:12px;margin:22px 0 8px}
.tile{background:var(--card);border:1px solid var(--line);border-radius:8px;padding:12px 14px}
.tile .what{color:var(--muted);font-size:12.5px}
.tile .value{font-size:25px;font-weight:620;line-height:1.25;font-variant-numeric:tabular-nums}
.tile .value small{font-size:14px;font-weight:500;color:var(--muted)}
.tile .how{color:var(--muted);font-size:12.5px}
.good{color:var(--good)}.warn{color:var(--warn)}.bad{color:var(--bad)}
figure{margin:0 0 18px}
figure svg{display:block;width:100%;height:auto;max-height:760px;background:var(--plate);border-radius:8px}
figcaption{padding-top:6px}
.pair{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(440px,100%),1fr));gap:16px}
.plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(440px,100%),1fr));gap:14px}
.plot{background:var(--card);border:1px solid var(--line);border-radius:8px;padding:10px;width:100%;height:auto}
.plot text{fill:var(--ink);font-size:12px;font-family:inherit}
.plot .title{font-size:13.5px;font-weight:600}
.plot .tick{fill:var(--muted);font-size:11px}
.plot .grid{stroke:var(--line)}
.plot .target{stroke:var(--accent);stroke-dasharray:5 4;stroke-width:1.3}.plot .target-text{fill:var(--accent)}
.plot .line{fill:none;stroke-width:1.6}
.plot .line.s1{stroke:var(--s1)}.plot .line.s2{stroke:var(--s2)}.plot .line.s3{stroke:var(--s3)}.plot .line.s4{stroke:var(--s4)}
.plot .dot.s1,.plot .bar.s1{fill:var(--s1)}.plot .dot.s2,.plot .bar.s2{fill:var(--s2)}
.plot .dot.s3,.plot .bar.s3{fill:var(--s3)}.plot .dot.s4,.plot .bar.s4{fill:var(--s4)}
.plot .line.dashed{stroke-dasharray:3 4}.plot .bar-line{stroke:var(--ink);stroke-width:2}
.key{display:inline-block;width:18px;height:3px;vertical-align:middle}.key.s1{background:var(--s1)}.key.s2{background:var(--s2)}
.plots+figure{margin-top:18px}
.columns{columns:2 440px;column-gap:14px}.columns .scroll{break-inside:avoid;margin-bottom:14px}
.colours{display:inline-block;width:160px;height:10px;vertical-align:middle;border-radius:2px}
.scroll{overflow-x:auto;border:1px solid var(--line);border-radius:8px;background:var(--card)}
table{border-collapse:collapse;width:100%;font-size:13px;font-variant-numeric:tabular-nums}
th,td{padding:6px 10px;text-align:right;white-space:nowrap;border-bottom:1px solid var(--line)}
tr:last-child td{border-bottom:0}
th{font-weight:600;color:var(--muted);font-size:12px;vertical-align:bottom}
th.t,td.t{text-align:left}td.w{white-space:normal;min-width:15em}
.chip{display:inline-block;padding:0 8px;border-radius:9px;border:1px solid currentColor;font-size:12px}
.frames{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(350px,100%),1fr));gap:14px}
.frame{background:var(--card);border:1px solid var(--line);border-radius:8px;padding:10px}
.frame b{font-weight:600}.frame .row{display:grid;grid-template-columns:repeat(3,1fr);gap:6px;margin-top:6px}
.frame img,.frame .none{width:100%;aspect-ratio:var(--shape);object-fit:contain;background:var(--plate);border-radius:4px;display:block}
.frame .none{display:grid;place-items:center;color:var(--muted);font-size:12px}
details{margin:10px 0}summary{cursor:pointer;color:var(--muted)}
.track{fill:none;stroke:#fff;stroke-width:1.8;stroke-linejoin:round}.track.dark{stroke:#10141a;stroke-opacity:.55;stroke-width:4}
.track.dashed{stroke-dasharray:9 6}.track.dotted{stroke-dasharray:2 5}
.stem{fill:none;stroke:#fff;stroke-opacity:.45;stroke-width:1}.stem.dark{stroke:#10141a;stroke-opacity:.3;stroke-width:2.2}
.stop{fill:#e4632a;stroke:#fff;stroke-width:1.3}
.number{font:600 13px system-ui,sans-serif;fill:#fff;stroke:#10141a;stroke-opacity:.75;stroke-width:3px;paint-order:stroke}
@media (max-width:600px){.number{font-size:26px}}
footer{margin-top:48px;border-top:1px solid var(--line);padding-top:14px}
code{font-size:.92em}
.keyframes th,.keyframes td{padding:5px 7px}.keyframes td.w{min-width:11em}
.keyframes th:first-child,.keyframes td:first-child{position:sticky;left:0;background:var(--card)}
@media (max-width:760px){main{padding:20px 12px 40px}.columns{columns:1}th,td{padding:4px 6px}
td.w{min-width:11em}.frame .row{grid-template-columns:1fr 1fr}}
@media (max-width:560px){.keyframes table,.keyframes tbody{display:block}.keyframes tr:first-child{display:none}
.keyframes tr{display:grid;grid-template-columns:1fr 1fr;gap:0 18px;padding:8px 10px;border-bottom:1px solid var(--line)}
.keyframes td,.keyframes td:first-child{position:static;display:block;text-align:right;padding:1px 0;border:0;
min-width:0;white-space:normal;overflow-wrap:anywhere}.keyframes td:first-child{font-weight:650}
.keyframes td::before{content:attr(data-title);color:var(--muted);font-weight:400;float:left;margin-right:8px}
.keyframes td:last-child{grid-column:1/-1}}
@media print{body{font-size:11px}main{padding:0}.frames{grid-template-columns:repeat(3,1fr)}}
)css";

}  // namespace

std::string begin_page(const std::string& title) {
  return "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
         "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><title>" +
         host::escaped(title) + "</title><style>" + report_style + "</style></head>\n<body><main>\n";
}

void write_report_html(const Report& report, std::ostream& out) {
  out << begin_page(report.title) << page_summary(report);
  out << page_joined(report);
  out << page_control(report);
  out << page_fixes(report);
  out << page_strips(report);
  out << page_landing(report);
  out << page_problems(report);
  out << page_score(report);
  out << page_accuracy(report);
  page_keyframe_table(report, out);
  out << page_captures(report);
  out << page_plots(report);
  out << page_cost(report);
  page_gallery(report, out);
  out << page_files(report);
  const bool copies = report.with_copies;
  out << "<footer class=\"note\"><p>Beside this page: <code>report.json</code> (all numbers), <code>model."
      << (copies ? "ply" : "glb") << "</code> (surface; "
      << (copies ? "MeshLab, CloudCompare, Blender" : "Blender, browsers")
      << "), <code>colmap/</code> (poses and points; COLMAP: File, Import model), <code>height."
      << (copies ? "pfm" : "tif")
      << "</code> and <code>ortho.png</code> (regular grid in the strip's world, <code>ortho.pgw</code> places it), "
         "<code>keyframes/</code> (decoded images, depths, masks). Further strips carry <code>-strip-N</code> in their "
         "names.</p></footer>\n</main></body></html>\n";
}

}  // namespace ilp::report
