#include "sim/sil/one_camera.hpp"

#include <algorithm>
#include <cmath>
#include <ostream>
#include <string>
#include <tuple>

#include "sim/host/text_format.hpp"

namespace ilp::sil {
namespace {

/// Leaves out those that do not agree with `usual`, and says how many and which is the first.
template <typename Agrees, typename Words>
void keep(std::vector<Photo>& all, const Photo& chosen, const char* what, Agrees agrees, Words words_of_photo,
          std::ostream& messages) {
  const Photo usual = chosen;
  const auto odd = std::find_if(all.begin(), all.end(), [&](const Photo& photo) { return !agrees(usual, photo); });
  if (odd == all.end()) return;
  const auto count = std::count_if(all.begin(), all.end(), [&](const Photo& photo) { return !agrees(usual, photo); });
  messages << "left out: " << host::counted(static_cast<std::size_t>(count), "photograph") << " of " << all.size()
           << " with another " << what << " than the others, " << words_of_photo(usual) << "; the first is "
           << odd->frame.file.string() << ", " << words_of_photo(*odd)
           << ": a flight has one camera, fly them from a folder of their own\n";
  std::erase_if(all, [&](const Photo& photo) { return !agrees(usual, photo); });
}

/// The photograph with which most agree; null where none states anything.
template <typename States, typename Agrees>
const Photo* most_usual(const std::vector<Photo>& all, States states, Agrees agrees) {
  const Photo* usual = nullptr;
  std::ptrdiff_t most = 0;
  for (const Photo& photo : all) {
    if (!photo.header || !states(photo)) continue;
    const auto count = std::count_if(all.begin(), all.end(), [&](const Photo& other) { return agrees(photo, other); });
    if (count <= most) continue;
    most = count;
    usual = &photo;
  }
  return usual;
}

bool same_size(const Photo& a, const Photo& b) {
  return !a.header || !b.header || (a.header->width == b.header->width && a.header->height == b.header->height);
}

std::string size_words(const Photo& photo) {
  return host::size_text(photo.header->width, photo.header->height) + " pixels";
}

bool same_shape(const Photo& photo, const host::ImageSize& size) {
  constexpr double most_apart = 0.01;
  const double shape = static_cast<double>(photo.header->width) / photo.header->height;
  return std::fabs(shape * size.height / size.width - 1) <= most_apart;
}

void keep_one_size(std::vector<Photo>& all, const std::optional<host::ImageSize>& of_camera, std::ostream& messages) {
  struct Group {
    const Photo* first = nullptr;
    std::ptrdiff_t count = 0;
  };
  std::vector<Group> groups;
  for (const Photo& photo : all) {
    if (!photo.header) continue;
    const auto found =
        std::find_if(groups.begin(), groups.end(), [&](const Group& group) { return same_size(*group.first, photo); });
    if (found == groups.end()) {
      groups.push_back({&photo, 1});
    } else {
      ++found->count;
    }
  }
  if (groups.size() < 2) return;
  const auto pixels = [](const Group& group) {
    return std::int64_t{group.first->header->width} * group.first->header->height;
  };
  const auto of_its_shape = [&](const Group& group) { return of_camera && same_shape(*group.first, *of_camera); };
  const auto rank = [&](const Group& group) { return std::tuple(of_its_shape(group), group.count, pixels(group)); };
  const auto less = [&](const Group& a, const Group& b) { return rank(a) < rank(b); };
  Group best = *std::max_element(groups.begin(), groups.end(), less);
  for (const Group& group : groups) {
    const host::ImageSize own{group.first->header->width, group.first->header->height};
    if (of_camera && own == *of_camera && 4 * group.count >= best.count) best = group;
  }
  keep(all, *best.first, "size", same_size, size_words, messages);
}

bool same_sensor(const Photo& a, const Photo& b) {
  return !a.header || !b.header || a.header->camera.empty() || b.header->camera.empty() ||
         a.header->camera == b.header->camera;
}

/// Whether both were taken with one focal length, as far as EXIF says.
bool same_lens(const Photo& a, const Photo& b) {
  if (!a.header || !b.header) return true;
  const auto same = [](const std::optional<double>& x, const std::optional<double>& y) {
    constexpr double most_apart = 0.01;
    return !x || !y || std::fabs(*x / *y - 1) <= most_apart;
  };
  return same(a.header->focal_mm, b.header->focal_mm) && same(a.header->focal_film_mm, b.header->focal_film_mm);
}

std::string lens_words(const Photo& photo) {
  const auto& [focal_mm, film_mm] = std::tie(photo.header->focal_mm, photo.header->focal_film_mm);
  std::string text = focal_mm ? host::brief(*focal_mm) + " mm" : "";
  if (film_mm) text += (focal_mm ? ", " : "") + host::brief(*film_mm) + " mm for 35 mm film";
  return text;
}

}  // namespace

void keep_one_camera(std::vector<Photo>& strip, const std::optional<host::ImageSize>& of_camera,
                     std::ostream& messages) {
  keep_one_size(strip, of_camera, messages);
  const auto names_camera = [](const Photo& photo) { return !photo.header->camera.empty(); };
  if (const Photo* const usual = most_usual(strip, names_camera, same_sensor))
    keep(
        strip, *usual, "sensor", same_sensor, [](const Photo& photo) { return photo.header->camera; }, messages);
  const auto names_lens = [](const Photo& photo) { return photo.header->focal_mm || photo.header->focal_film_mm; };
  if (const Photo* const usual = most_usual(strip, names_lens, same_lens))
    keep(strip, *usual, "focal length", same_lens, lens_words, messages);
}

}  // namespace ilp::sil
