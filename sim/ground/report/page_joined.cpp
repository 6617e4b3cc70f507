// Strips that stand in one model, how well the ground closes its loops, and the tracks before and after.

#include <algorithm>
#include <map>
#include <string>

#include "sim/ground/report/page_sections.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

using Members = std::vector<model::JoinedModel::Member>;

/// A frame of the picture: what lies in it, to scale, with +y upwards.
class Plan {
 public:
  Plan(double left, double width, double height) : left_(left), width_(width), height_(height) {}

  void take(const Vec3& point) {
    for (int k = 0; k < 2; ++k) {
      low_[k] = any_ ? std::min(low_[k], point[k]) : point[k];
      high_[k] = any_ ? std::max(high_[k], point[k]) : point[k];
    }
    any_ = true;
  }
  [[nodiscard]] std::string x(const Vec3& point) const {
    return host::fixed(left_ + 0.5 * width_ + (point.x() - 0.5 * (low_[0] + high_[0])) * scale(), 1);
  }
  [[nodiscard]] std::string y(const Vec3& point) const {
    return host::fixed(0.5 * height_ - (point.y() - 0.5 * (low_[1] + high_[1])) * scale(), 1);
  }

 private:
  [[nodiscard]] double scale() const {
    constexpr double margin = 0.86;
    const double wide = high_[0] - low_[0], high = high_[1] - low_[1];
    const double by_width = wide > 0 ? width_ / wide : 1e9, by_height = high > 0 ? height_ / high : 1e9;
    return margin * std::min(by_width, by_height);
  }

  double left_, width_, height_;
  double low_[2] = {}, high_[2] = {};
  bool any_ = false;
};

std::string polyline(const Plan& plan, const std::vector<Vec3>& centres, const char* style) {
  std::string svg = std::string("<polyline class=\"") + style + "\" points=\"";
  for (const Vec3& centre : centres) svg += plan.x(centre) + "," + plan.y(centre) + " ";
  svg += "\"/>";
  for (const Vec3& centre : centres)
    svg += "<circle class=\"stop\" cx=\"" + plan.x(centre) + "\" cy=\"" + plan.y(centre) + "\" r=\"3\"/>";
  return svg;
}

/// On the left each strip in its own world, on the right all in one, with the links.
std::string tracks(const model::JoinedModel& joined) {
  constexpr double width = 1200, height = 420;
  std::map<std::int64_t, std::vector<Vec3>> before, after;
  std::map<std::int64_t, Vec3> places;
  Plan right(0.5 * width, 0.5 * width, height);
  for (const model::JoinedModel::Member& member : joined.members) {
    if (member.posed_by_flight) before[member.strip_id].push_back(member.before);
    after[member.strip_id].push_back(member.after);
    places[member.keyframe_id] = member.after;
    right.take(member.after);
  }
  std::string svg =
      "<svg viewBox=\"0 0 1200 420\" role=\"img\" aria-label=\"tracks before and after joining\">"
      "<rect width=\"1200\" height=\"420\" fill=\"#20262e\"/>";
  const double part = 0.5 * width / static_cast<double>(std::max<std::size_t>(before.size(), 1));
  double left = 0;
  for (const auto& [strip, centres] : before) {
    Plan plan(left, part, height);
    for (const Vec3& centre : centres) plan.take(centre);
    svg += polyline(plan, centres, "track") + "<text class=\"number\" x=\"" + host::fixed(left + 0.5 * part, 1) +
           "\" y=\"16\" text-anchor=\"middle\">strip " + std::to_string(strip) + "</text>";
    left += part;
  }
  for (const model::ClosedLink& link : joined.links) {
    const Vec3 &a = places[link.place_id], &b = places[link.keyframe_id];
    svg += "<line class=\"stem\" x1=\"" + right.x(a) + "\" y1=\"" + right.y(a) + "\" x2=\"" + right.x(b) + "\" y2=\"" +
           right.y(b) + "\"/>";
  }
  for (const auto& [strip, centres] : after) svg += polyline(right, centres, "track");
  return "<figure>" + svg +
         "</svg><figcaption>Left: the strips as the flight states them, each in its own world. Right: the same "
         "keyframes in one model; thin lines are links.</figcaption></figure>\n";
}

std::string list_of(const std::vector<std::int64_t>& ids) {
  std::string text;
  for (const std::int64_t id : ids) text += (text.empty() ? "" : ", ") + std::to_string(id);
  return text;
}

std::string links_table(const model::JoinedModel& joined) {
  if (joined.links.empty()) return "";
  std::string html =
      "<details><summary>Links</summary><div class=\"scroll\"><table><tr><th>keyframe</th><th>sees ground "
      "of</th><th>strips</th><th>points in common</th><th>error by the flight's poses, px</th><th>in the model, "
      "px</th></tr>\n";
  for (const model::ClosedLink& link : joined.links) {
    html += "<tr>" + cell(std::to_string(link.keyframe_id)) + cell(std::to_string(link.place_id)) +
            cell(std::to_string(link.strip_id) + ", " + std::to_string(link.place_strip_id)) +
            cell(std::to_string(link.points)) + cell(link.before_px > 0 ? host::brief(link.before_px) : "") +
            cell(link.points > 0 ? host::brief(link.after_px) : "") + "</tr>\n";
  }
  return html + "</table></div></details>\n";
}

std::string height_steps(const model::JoinedModel& joined) {
  const auto reported = [](const model::HeightSteps& steps) {
    return host::brief(steps.median_percent) + " % of the flying height in the median and " +
           host::brief(steps.p95_percent) + " % in 95 of 100 cases";
  };
  const model::HeightSteps &before = joined.steps_before, &after = joined.steps_after;
  if (after.samples == 0) return "";
  std::string html = "<p>Where two passes have depths of the same ground, their heights differ by " + reported(after) +
                     " (" + host::counted(after.samples, "place") + " of " + host::counted(after.pairs, "pair") +
                     " of keyframes)";
  if (before.samples > 0)
    html +=
        "; by the poses of the flight it was " + reported(before) + " (" + host::counted(before.samples, "place") + ")";
  return html + ".</p>\n";
}

}  // namespace

std::string page_joined(const Report& report) {
  if (report.joined.models.empty() && report.joined.apart.empty()) return "";
  std::string html = "<h2>One model</h2>\n";
  for (const model::JoinedModel& joined : report.joined.models) {
    const bool several = joined.strips.size() > 1;
    html += "<p>" + host::counted(joined.members.size(), "keyframe") + " of strip" + (several ? "s " : " ") +
            list_of(joined.strips) + " stand in one model, shown as strip " + std::to_string(joined.strip_id) + ": " +
            host::counted(joined.points, "point") + " seen " + std::to_string(joined.sightings) +
            " times, median error " + host::brief(joined.median_error_px) + " px.";
    if (joined.by_ties) html += " Some strips stand where the flight's ties put them, because no points join them.";
    html += "</p>\n" + tracks(joined) + height_steps(joined) + links_table(joined);
  }
  for (const model::StripApart& apart : report.joined.apart) {
    html += "<p class=\"note\">Strip " + std::to_string(apart.strip_id) + " stays apart with " +
            host::counted(apart.keyframes, "keyframe") + ": " + apart.why + ".</p>\n";
  }
  return html;
}

}  // namespace ilp::report
