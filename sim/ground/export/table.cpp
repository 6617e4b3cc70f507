#include "sim/ground/export/table.hpp"

#include <cpl_string.h>
#include <ogrsf_frmts.h>

#include <memory>
#include <optional>
#include <stdexcept>
#include <system_error>

#include "sim/ground/export/feature.hpp"
#include "sim/host/files.hpp"
#include "sim/host/gdal_session.hpp"

namespace ilp::exports {
namespace {
namespace fs = std::filesystem;

std::string in_json_string(const std::string& text) {
  std::string escaped;
  for (const char c : text) escaped += (c == '"' || c == '\\' ? "\\" : "") + std::string(1, c);
  return escaped;
}

/// GDAL writes no local system of coordinates, and readers take a file without one for longitude and latitude. The
/// member `crs` of the format's first version (2008) names it.
void name_local_crs(const fs::path& path, const std::string& crs) {
  const std::vector<std::uint8_t> bytes = host::read_file(path);
  std::string text(bytes.begin(), bytes.end());
  const std::string features = "\"features\": [";
  const std::size_t at = text.find(features);
  if (at == std::string::npos) throw std::logic_error("GeoJSON without features");
  text.insert(at, R"("crs": { "type": "name", "properties": { "name": ")" + in_json_string(crs) + "\" } },\n");
  host::write_file(path, text);
}

// One layer in one file, under another name until it is complete.
class LayerFile {
 public:
  LayerFile(const char* driver_name, const fs::path& path) : path_(path), part_(path) {
    part_.replace_filename("." + path.filename().string() + ".part" + path.extension().string());
    std::error_code ignored;
    fs::remove(part_, ignored);
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName(driver_name);
    if (!driver) throw std::runtime_error(std::string("this GDAL has no driver ") + driver_name);
    dataset_.reset(driver->Create(part_.c_str(), 0, 0, 0, GDT_Unknown, nullptr));
    if (!dataset_) fail();
  }
  ~LayerFile() {
    dataset_.reset();
    std::error_code ignored;
    fs::remove(part_, ignored);
  }
  LayerFile(const LayerFile&) = delete;
  LayerFile& operator=(const LayerFile&) = delete;

  void begin_layer(OGRSpatialReference* crs, OGRwkbGeometryType kind, const CPLStringList& options,
                   const std::vector<Column>& columns) {
    layer_ = dataset_->CreateLayer(path_.stem().c_str(), crs, kind, const_cast<char**>(options.List()));
    if (!layer_) fail();
    for (const Column& column : columns) {
      OGRFieldDefn field(column.name.c_str(), type_of(column.type));
      if (layer_->CreateField(&field) != OGRERR_NONE) fail();
    }
  }

  void add(const std::vector<Cell>& cells, Geometry geometry) {
    OGRFeature feature(layer_->GetLayerDefn());
    set_fields(feature, cells);
    if (geometry) feature.SetGeometryDirectly(geometry.release());
    if (layer_->CreateFeature(&feature) != OGRERR_NONE) fail();
  }

  /// `local_crs`: name of a GeoJSON file's own system of coordinates; empty: GDAL has written it.
  void finish(const std::string& local_crs = {}) {
    CPLErrorReset();
    dataset_.reset();
    if (CPLGetLastErrorType() == CE_Failure) fail();
    if (!local_crs.empty()) name_local_crs(part_, local_crs);
    host::move_into_place(part_, path_);
  }

 private:
  [[noreturn]] void fail() const { throw host::gdal_error("cannot write " + path_.string()); }

  fs::path path_, part_;
  host::Dataset dataset_;
  OGRLayer* layer_ = nullptr;
};

std::string description_of(const Georeference& place, const std::string& title) {
  return title + ". Coordinates: " +
         (place.on_a_body() ? "longitude (east) and latitude in degrees, " + place.height_name + ", in metres. "
                            : "x, y, z of the strip's own axes in " + place.unit + "s, not longitude and latitude. ") +
         "Here " + place.sentence;
}

CPLStringList geojson_options(const Georeference& place, const std::string& title) {
  CPLStringList options;
  options.SetNameValue("DESCRIPTION", description_of(place, title).c_str());
  options.SetNameValue("RFC7946", place.earth ? "YES" : "NO");
  // A ten-millionth of a degree is a centimetre on the Earth.
  options.SetNameValue("COORDINATE_PRECISION", place.on_a_body() ? "9" : "6");
  return options;
}

}  // namespace

void write_csv(const Table& table, const fs::path& path) {
  const host::GdalSession gdal;
  LayerFile file("CSV", path);
  CPLStringList options;
  options.SetNameValue("LINEFORMAT", "LF");
  options.SetNameValue("STRING_QUOTING", "IF_NEEDED");
  file.begin_layer(nullptr, wkbNone, options, table.columns);
  for (const std::vector<Cell>& row : table.rows) file.add(row, nullptr);
  file.finish();
}

void write_geojson(const Table& table, const std::vector<Shape>& shapes, const Georeference& place,
                   const std::string& title, const fs::path& path) {
  const host::GdalSession gdal;
  if (shapes.size() != table.rows.size()) throw std::logic_error("a shape for every row");
  OGRSpatialReference crs;
  const bool known = place.on_a_body() && crs.SetFromUserInput(place.geographic.c_str()) == OGRERR_NONE;
  crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  LayerFile file("GeoJSON", path);
  file.begin_layer(known ? &crs : nullptr, wkbUnknown, geojson_options(place, title), table.columns);
  const Placement placed(place);
  for (std::size_t i = 0; i < shapes.size(); ++i) file.add(table.rows[i], geometry_of(shapes[i], placed));
  file.finish(known ? std::string() : place.crs);
}

}  // namespace ilp::exports
