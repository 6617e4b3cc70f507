#include "sim/sil/flyable_images.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <fstream>
#include <iomanip>
#include <ostream>
#include <set>
#include <stdexcept>
#include <string>

#include "sim/host/files.hpp"
#include "sim/host/grey_photograph.hpp"
#include "sim/host/image_io.hpp"
#include "sim/host/photograph.hpp"
#include "sim/host/text_format.hpp"
#include "sim/sil/one_camera.hpp"

namespace ilp::sil {
namespace fs = std::filesystem;
namespace {

std::vector<Photo> photos_of(const std::vector<host::StripFrame>& strip) {
  std::vector<Photo> all;
  for (const host::StripFrame& frame : strip) {
    Photo& photo = all.emplace_back();
    photo.frame = frame;
    photo.original = frame.file;
    try {
      photo.header = host::read_photograph_facts(frame.file);
    } catch (const host::TooLargePhotograph& fault) {
      photo.fault = fault.what();
      photo.too_large = true;
    } catch (const std::exception& fault) {
      photo.fault = fault.what();
    }
  }
  return all;
}

bool has_blank(const fs::path& file) {
  return fs::absolute(file).string().find_first_of(" \t\r\n") != std::string::npos;
}

int binning_of(const std::vector<Photo>& all) {
  int binning = 1;
  for (const Photo& photo : all) {
    if (photo.header) binning = std::max(binning, host::binning_for(photo.header->width, photo.header->height));
  }
  return binning;
}

/// Of the photographs of more than 8 bits.
host::GreyRange range_of(const std::vector<Photo>& all) {
  std::vector<fs::path> deep;
  for (const Photo& photo : all) {
    if (photo.header && photo.header->deep) deep.push_back(photo.frame.file);
  }
  return host::grey_range(deep);
}

/// The flight carries the name of the file: one that it cannot carry becomes another one.
bool has_another_name(const fs::path& file) {
  return host::image_key(file.filename().string()) != file.stem().string();
}

/// A name that no other image has.
std::string name_for(const fs::path& file, std::set<std::string>& used) {
  const std::string stem = host::image_key(file.filename().string());
  std::string name = stem + ".png";
  for (int i = 2; !used.insert(name).second; ++i) name = stem + "-" + std::to_string(i) + ".png";
  return name;
}

/// What the flight itself reports: a file that is not there, or a damaged one of a format that its camera reads.
bool is_reported_by_the_flight(const Photo& photo) {
  std::error_code error;
  return !fs::exists(photo.frame.file, error) || host::is_png_or_pgm(photo.frame.file);
}

void leave_out(const Photo& photo, std::ostream& messages) {
  messages << "left out: " << photo.fault << "\n";
}

/// Leaves out, by name, what cannot be read.
void keep_readable(std::vector<Photo>& all, std::ostream& messages) {
  std::erase_if(all, [&](const Photo& photo) {
    const bool out = !photo.header && (photo.too_large || !is_reported_by_the_flight(photo));
    if (out) leave_out(photo, messages);
    return out;
  });
}

/// Makes the image that flies in place of this one; false for a damaged one.
bool convert(Photo& photo, const fs::path& place, int binning, const host::GreyRange& range) {
  // A flight that goes on has them already.
  if (fs::exists(place)) return true;
  try {
    host::write_png(place, host::grey_of(host::read_photograph(photo.frame.file), binning, range).view());
  } catch (const host::DamagedPhotograph& fault) {
    photo.fault = fault.what();
    return false;
  }
  return true;
}

/// Images that do not fly as they are become files in `folder`; damaged ones are left out by name.
void make_files(const fs::path& folder, int binning, std::vector<Photo>& all, std::ostream& messages) {
  const bool any_deep =
      std::any_of(all.begin(), all.end(), [](const Photo& photo) { return photo.header && photo.header->deep; });
  const host::GreyRange range = any_deep ? range_of(all) : host::GreyRange{};
  std::set<std::string> used;
  std::size_t changed = 0, renamed = 0;
  std::vector<Photo> kept;
  for (Photo& photo : all) {
    const fs::path file = photo.frame.file;
    const bool flies = host::is_png_or_pgm(file) && photo.header && !photo.header->deep && binning == 1 &&
                       !has_blank(file) && !has_another_name(file);
    if (photo.header && !flies) {
      fs::create_directories(folder);
      const fs::path place = folder / name_for(file, used);
      if (!convert(photo, place, binning, range)) {
        leave_out(photo, messages);
        continue;
      }
      photo.frame.file = place;
      ++changed;
      renamed += has_another_name(file) ? 1 : 0;
    }
    kept.push_back(photo);
  }
  all = std::move(kept);
  if (changed > 0) messages << changed << " images are converted to 8-bit PNG files in " << folder.string() << "\n";
  if (renamed > 0)
    messages << renamed << " of them have names that the flight cannot carry, and fly under others made of these\n";
  if (any_deep)
    messages << "16-bit values from " << range.black << " to " << range.white << " become grey values from 0 to 255\n";
}

void take_places(const std::vector<Photo>& all, FlyableImages& result, std::ostream& messages) {
  std::size_t faults = 0;
  std::string first;
  for (const Photo& photo : all) {
    result.places.push_back(photo.header ? photo.header->place : std::nullopt);
    result.attitudes.push_back(photo.header ? StatedAttitude{photo.header->gimbal, photo.header->direction_deg}
                                            : StatedAttitude{});
    if (!photo.header || photo.header->place_fault.empty()) continue;
    if (++faults == 1) first = photo.original.string() + ": " + photo.header->place_fault;
  }
  if (faults > 0) messages << faults << " positions in EXIF are not used, the first in " << first << "\n";
}

}  // namespace

FlyableImages make_flyable(const std::vector<host::StripFrame>& strip, const fs::path& folder, std::ostream& messages,
                           const std::optional<host::ImageSize>& of_camera) {
  std::vector<Photo> all = photos_of(strip);
  keep_readable(all, messages);
  keep_one_camera(all, of_camera, messages);
  FlyableImages result;
  result.epoch = take_stated_times(all, messages);
  result.binning = binning_of(all);
  for (const Photo& photo : all) {
    if (!photo.header) continue;
    if (result.source == host::ImageSize{}) result.source = {photo.header->width, photo.header->height};
    if (!result.field_of_view_rad) result.field_of_view_rad = photo.header->field_of_view_rad;
    if (result.lens_fault.empty()) result.lens_fault = photo.header->lens_fault;
  }
  make_files(folder, result.binning, all, messages);
  for (const Photo& photo : all) result.frames.push_back(photo.frame);
  if (result.binning > 1)
    messages << "the images are larger than the flight takes: " << result.binning << " x " << result.binning
             << " of their pixels become one\n";
  if (!result.lens_fault.empty()) messages << "the focal length in EXIF is not used: " << result.lens_fault << "\n";
  take_places(all, result, messages);
  return result;
}

std::array<double, 4> attitude_of(const host::GimbalAngles& gimbal) {
  constexpr double rad = 3.14159265358979323846 / 180;
  using Turn = Eigen::AngleAxisd;
  // A camera without angles looks north: its x is east, its y is down.
  Eigen::Matrix3d level_from_north;
  level_from_north << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  const Eigen::Matrix3d level_from_camera = Turn(-gimbal.yaw_deg * rad, Eigen::Vector3d::UnitZ()) *
                                            Turn(gimbal.pitch_deg * rad, Eigen::Vector3d::UnitX()) * level_from_north *
                                            Turn(gimbal.roll_deg * rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Quaterniond q(level_from_camera.transpose());
  return {q.w(), q.x(), q.y(), q.z()};
}

namespace {

/// The columns of an attitude: of the gimbal, or of a camera that looks straight down.
void write_attitude(const StatedAttitude& stated, bool looks_down, std::ostream& out) {
  constexpr double gimbal_tilt_sigma_rad = 0.02, compass_sigma_rad = 0.1;
  constexpr double down_sigma_rad = 0.1, direction_sigma_rad = 0.4;  // north may be the compass's
  const auto write = [&](const std::array<double, 4>& q, double tilt_sigma_rad, double heading_sigma_rad) {
    out << std::setprecision(9);
    for (const double part : q) out << "," << part;
    out << std::setprecision(3) << "," << tilt_sigma_rad << ",";
    if (heading_sigma_rad > 0) out << heading_sigma_rad;
    out << "\n";
  };
  if (stated.gimbal) {
    write(attitude_of(*stated.gimbal), gimbal_tilt_sigma_rad, compass_sigma_rad);
  } else if (looks_down && stated.direction_deg) {
    write(attitude_of({*stated.direction_deg, -90, 0}), down_sigma_rad, direction_sigma_rad);
  } else if (looks_down) {
    // The image's x to the east, its y to the south; the heading is not known.
    write({0, 1, 0, 0}, down_sigma_rad, 0);
  } else {
    out << ",,,,,,\n";
  }
}

}  // namespace

bool write_places(const FlyableImages& images, const PlaceOptions& options, const fs::path& file,
                  std::ostream& messages) {
  std::size_t count = 0;
  for (const auto& place : images.places) count += place ? 1 : 0;
  if (count < fewest_places) return false;
  const auto gimbals = static_cast<std::size_t>(
      std::count_if(images.attitudes.begin(), images.attitudes.end(), [](const auto& a) { return a.gimbal; }));
  const bool looks_down = options.looks_down && gimbals == 0, any_attitude = looks_down || gimbals > 0;
  std::ofstream out(file, std::ios::binary);
  out << "# positions that EXIF states"
      << (looks_down    ? ", and a camera that looks straight down"
          : gimbals > 0 ? ", and the angles of the gimbal"
                        : "")
      << "\n"
      << "time_s,longitude_deg,latitude_deg,horizontal_sigma_m,elevation_m,vertical_sigma_m"
      << (any_attitude ? ",qw,qx,qy,qz,tilt_sigma_rad,heading_sigma_rad\n" : "\n") << std::fixed;
  for (std::size_t i = 0; i < images.frames.size() && i < images.places.size(); ++i) {
    const std::optional<host::GeoTag>& place = images.places[i];
    if (!place) continue;
    const double sigma = place->horizontal_error_m.value_or(options.sigma_m);
    out << std::setprecision(9) << 1e-9 * static_cast<double>(images.frames[i].time_ns) << "," << place->longitude_deg
        << "," << place->latitude_deg << "," << std::setprecision(3) << sigma << ",";
    if (place->elevation_m) out << *place->elevation_m << "," << 2 * sigma;
    if (!place->elevation_m) out << ",";
    if (any_attitude)
      write_attitude(i < images.attitudes.size() ? images.attitudes[i] : StatedAttitude{}, looks_down, out);
    else
      out << "\n";
  }
  if (!out.flush()) throw std::runtime_error(file.string() + ": cannot be written");
  messages << "navigation: the positions that EXIF states in " << count << " of " << images.frames.size()
           << " images, on the Earth, one sigma " << options.sigma_m << " m where an image states no error\n";
  if (looks_down) messages << "navigation: the camera counts as looking straight down to 6 degrees, one sigma\n";
  if (gimbals > 0)
    messages << "navigation: the camera's attitude is that of its gimbal, which " << gimbals << " images state\n";
  return true;
}

CameraModel binned_camera(const CameraModel& camera, int binning) {
  CameraModel result = camera;
  result.width = camera.width / binning;
  result.height = camera.height / binning;
  result.fx = camera.fx / binning;
  result.fy = camera.fy / binning;
  // Pixel centres are at integers.
  result.cx = (camera.cx + 0.5) / binning - 0.5;
  result.cy = (camera.cy + 0.5) / binning - 0.5;
  return result;
}

}  // namespace ilp::sil
