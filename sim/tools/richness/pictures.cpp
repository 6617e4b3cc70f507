#include "sim/tools/richness/pictures.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "sim/host/parallel.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::richness {
namespace {

constexpr int plot_px = 400;
constexpr int left_px = 50;
constexpr int top_px = 20;

std::string text_at(double x, double y, const std::string& anchor, const std::string& text) {
  std::array<char, 256> line{};
  std::snprintf(line.data(), line.size(), "<text x=\"%.0f\" y=\"%.0f\" text-anchor=\"%s\">%s</text>\n", x, y,
                anchor.c_str(), text.c_str());
  return line.data();
}

std::string curve(const std::vector<ScoredImage>& images, const char* colour, double width) {
  std::string path;
  for (const auto& [x, y] : roc_curve(images)) {
    std::array<char, 48> point{};
    std::snprintf(point.data(), point.size(), "%.1f,%.1f ", left_px + plot_px * x, top_px + plot_px * (1 - y));
    path += point.data();
  }
  std::array<char, 96> style{};
  std::snprintf(style.data(), style.size(), "fill=\"none\" stroke=\"%s\" stroke-width=\"%.1f\"", colour, width);
  return "<polyline " + std::string(style.data()) + " points=\"" + path + "\"/>\n";
}

/// A keyframe's newly seen strip in its place of the sheet.
struct Tile {
  double index = 0;
  bool interesting = false;
  host::Raster<std::uint8_t> picture;
};

constexpr int tile_width = 84;
constexpr int tile_height = 248;
constexpr int frame_px = 4;

/// The right end of the image, where new ground comes in, stretched around its mean; what is not new is dark.
host::Raster<std::uint8_t> strip_picture(const PlantedKeyframe& keyframe) {
  double sum = 0;
  double count = 0;
  for (std::size_t i = 0; i < keyframe.mask.samples.size(); ++i) {
    if (keyframe.mask.samples[i] == 0) continue;
    sum += keyframe.grey.samples[i];
    count += 1;
  }
  const double mean = count > 0 ? sum / count : 0;
  host::Raster<std::uint8_t> picture(tile_width - 2 * frame_px, tile_height - 2 * frame_px);
  const int first = keyframe.grey.width - picture.width;
  for (int y = 0; y < std::min(picture.height, keyframe.grey.height); ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const double grey = 128 + 200 * (keyframe.grey.at(first + x, y) - mean) / std::max(mean, 1.0);
      const double dim = keyframe.mask.at(first + x, y) != 0 ? 1 : 0.35;
      picture.at(x, y) = static_cast<std::uint8_t>(dim * std::clamp(grey, 0.0, 255.0));
    }
  }
  return picture;
}

std::vector<Tile> tiles_of(const PlantedWorld& planted, const RichnessParams& params) {
  const StereoScratchPointer scratch = make_stereo_scratch();
  const auto workspace = std::make_unique<RichnessWorkspace>();
  RichnessHistory history;
  std::vector<Tile> tiles;
  for (const PlantedKeyframe& keyframe : planted_keyframes(planted, Viewing{}, *scratch)) {
    Tile tile;
    RichnessCues cues;
    host::require(
        score_richness(keyframe.camera, keyframe.grey.view(), keyframe.inverse_depth.view(), keyframe.sigma.view(),
                       keyframe.mask.view(), params, history, *workspace, cues, tile.index),
        "richness");
    learn(cues, params, history);
    // The first keyframe's new part is the whole image: no strip.
    if (keyframe.label() == Label::neither || keyframe.newly_seen > 0.4) continue;
    tile.interesting = keyframe.label() == Label::interesting;
    tile.picture = strip_picture(keyframe);
    tiles.push_back(std::move(tile));
  }
  return tiles;
}

}  // namespace

std::string roc_svg(const std::vector<EvaluatedImage>& images) {
  constexpr std::array colours = {"#1f77b4", "#2ca02c", "#d62728", "#9467bd", "#ff7f0e"};
  std::string svg =
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"680\" height=\"480\" font-family=\"sans-serif\" "
      "font-size=\"13\">\n<rect width=\"680\" height=\"480\" fill=\"white\"/>\n";
  for (int k = 0; k <= 5; ++k) {
    std::array<char, 200> line{};
    const double at = 0.2 * k;
    std::snprintf(line.data(), line.size(), "<path d=\"M%.0f %d v%d M%d %.0f h%d\" stroke=\"#ddd\" fill=\"none\"/>\n",
                  left_px + plot_px * at, top_px, plot_px, left_px, top_px + plot_px * at, plot_px);
    svg += line.data();
    std::array<char, 8> number{};
    std::snprintf(number.data(), number.size(), "%.1f", at);
    svg += text_at(left_px + plot_px * at, top_px + plot_px + 18, "middle", number.data());
    svg += text_at(left_px - 8, top_px + plot_px * (1 - at) + 5, "end", number.data());
  }
  svg += text_at(left_px + 0.5 * plot_px, top_px + plot_px + 40, "middle", "share of plain images above the threshold");
  svg += text_at(left_px + 8, top_px + 16, "start", "share of interesting images above it");
  const Choice any = [](const EvaluatedImage&) { return true; };
  double y = top_px + 160;
  const auto add = [&](const std::string& name, const std::vector<ScoredImage>& chosen, const char* colour,
                       double width) {
    svg += curve(chosen, colour, width);
    std::array<char, 96> label{};
    std::snprintf(label.data(), label.size(), "%s: AUC %.3f", name.c_str(), area_under_roc(chosen, 0).value);
    svg += "<g fill=\"" + std::string(colour) + "\">" + text_at(left_px + plot_px + 16, y, "start", label.data()) +
           "</g>\n";
    y += 24;
  };
  for (std::size_t k = 0; k < planted_kinds().size(); ++k) {
    const world::FeatureKind feature = planted_kinds()[k];
    const Choice shown = [&](const EvaluatedImage& image) { return image.feature == feature; };
    add(std::string(name_of(feature)), scored(images, shown, any), colours[k], 1.5);
  }
  add("all", scored(images), "black", 3);
  return svg + "</svg>\n";
}

void write_contact_sheet(const std::filesystem::path& path, const WorldRange& range, const RichnessParams& params,
                         int count, std::size_t threads) {
  std::vector<std::vector<Tile>> worlds(range.worlds());
  host::for_each_parallel(
      worlds.size(), [&](std::size_t k) { worlds[k] = tiles_of(range.world(k), params); }, threads);
  std::vector<const Tile*> ranked;
  for (const auto& world : worlds) {
    for (const Tile& tile : world) ranked.push_back(&tile);
  }
  std::sort(ranked.begin(), ranked.end(), [](const Tile* a, const Tile* b) { return a->index > b->index; });
  if (ranked.empty()) throw std::runtime_error("no keyframe of these worlds is interesting or plain");
  const int shown = std::min(count, static_cast<int>(ranked.size()));
  const int columns = std::min(shown, 16);
  const int rows = (shown + columns - 1) / columns;
  host::Raster<host::Rgb> sheet(columns * tile_width, rows * tile_height);
  for (int k = 0; k < shown; ++k) {
    const Tile& tile = *ranked[static_cast<std::size_t>(k) * ranked.size() / static_cast<std::size_t>(shown)];
    const host::Rgb frame = tile.interesting ? host::Rgb{40, 190, 70} : host::Rgb{200, 60, 50};
    const int x0 = k % columns * tile_width;
    const int y0 = k / columns * tile_height;
    for (int y = 0; y < tile_height - 2; ++y) {
      for (int x = 0; x < tile_width - 2; ++x) sheet.at(x0 + x, y0 + y) = frame;
    }
    for (int y = 0; y < tile.picture.height; ++y) {
      for (int x = 0; x < tile.picture.width; ++x) {
        const std::uint8_t grey = tile.picture.at(x, y);
        sheet.at(x0 + frame_px - 1 + x, y0 + frame_px - 1 + y) = {grey, grey, grey};
      }
    }
  }
  host::write_png(path, static_cast<const host::Raster<host::Rgb>&>(sheet).view());
}

}  // namespace ilp::richness
