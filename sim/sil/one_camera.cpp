#include "sim/sil/one_camera.hpp"

#include <algorithm>
#include <cmath>
#include <map>
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

/// So many of the most frequent statements are compared with all: where a zoom makes more, the time stays linear.
constexpr std::size_t most_candidates = 500;

/// The first photograph of the statement with which most agree; null where none states anything. `key_of` is what a
/// photograph states, and photographs of one key agree.
template <typename States, typename KeyOf, typename Agrees>
const Photo* most_usual(const std::vector<Photo>& all, States states, KeyOf key_of, Agrees agrees) {
  struct Group {
    const Photo* first = nullptr;
    std::size_t count = 0;
  };
  std::map<decltype(key_of(all.front())), Group> by_key;
  for (const Photo& photo : all) {
    if (!photo.header || !states(photo)) continue;
    Group& group = by_key[key_of(photo)];
    if (group.count++ == 0) group.first = &photo;
  }
  std::vector<Group> groups;
  for (const auto& [key, group] : by_key) groups.push_back(group);
  std::sort(groups.begin(), groups.end(),
            [](const Group& a, const Group& b) { return a.count != b.count ? a.count > b.count : a.first < b.first; });
  Group usual;
  for (std::size_t i = 0; i < std::min(groups.size(), most_candidates); ++i) {
    Group agreeing{groups[i].first, 0};
    for (const Group& other : groups) agreeing.count += agrees(*agreeing.first, *other.first) ? other.count : 0;
    if (agreeing.count > usual.count || (agreeing.count == usual.count && agreeing.first < usual.first))
      usual = agreeing;
  }
  return usual.first;
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
  const auto sensor_of = [](const Photo& photo) { return photo.header->camera; };
  if (const Photo* const usual = most_usual(strip, names_camera, sensor_of, same_sensor))
    keep(strip, *usual, "sensor", same_sensor, sensor_of, messages);
  const auto names_lens = [](const Photo& photo) { return photo.header->focal_mm || photo.header->focal_film_mm; };
  const auto lens_of = [](const Photo& photo) {
    return std::tuple(photo.header->focal_mm, photo.header->focal_film_mm);
  };
  if (const Photo* const usual = most_usual(strip, names_lens, lens_of, same_lens))
    keep(strip, *usual, "focal length", same_lens, lens_words, messages);
}

}  // namespace ilp::sil
