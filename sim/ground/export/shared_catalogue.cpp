#include "sim/ground/export/shared_catalogue.hpp"

#include <cpl_error.h>
#include <ogrsf_frmts.h>

#include <memory>
#include <stdexcept>

#include "sim/ground/export/feature.hpp"
#include "sim/ground/export/flight_tables.hpp"
#include "sim/host/gdal_session.hpp"

namespace ilp::exports {
namespace {

// Missions that begin at the same time must not create the same tables.
constexpr const char* lock = "SELECT pg_advisory_xact_lock(hashtext('aerobot catalogue'))";

// A footprint runs on through 180 degrees, so that its place may be written with another whole turn.
constexpr const char* function =
    "CREATE FUNCTION aerobot.seen(on_body text, longitude double precision, latitude double precision) "
    "RETURNS TABLE(mission text, keyframe bigint, strip bigint, name text) LANGUAGE sql STABLE AS $$ "
    "SELECT k.mission, k.keyframe, k.strip, k.name FROM aerobot.keyframe k WHERE k.body = on_body AND "
    "(ST_Intersects(k.footprint, ST_MakePoint(longitude, latitude)) OR "
    "ST_Intersects(k.footprint, ST_MakePoint(longitude - 360, latitude)) OR "
    "ST_Intersects(k.footprint, ST_MakePoint(longitude + 360, latitude))) ORDER BY k.mission, k.keyframe $$";

const char* sql_type(ColumnType type) {
  return type == ColumnType::integer ? "bigint" : type == ColumnType::real ? "double precision" : "text";
}

std::string table_definition() {
  std::string sql = "CREATE TABLE aerobot.keyframe(mission text NOT NULL, body text";
  for (const Column& column : keyframe_columns()) sql += ", " + column.name + " " + sql_type(column.type);
  return sql + ", footprint geometry(PolygonZ), UNIQUE(mission, keyframe))";
}

std::string quoted(const std::string& text) {
  std::string sql = "'";
  for (const char c : text) sql += c == '\'' ? std::string("''") : std::string(1, c);
  return sql + "'";
}

void check_address(const std::string& address) {
  constexpr const char* scheme = "postgresql://";
  if (!address.starts_with(scheme))
    throw std::runtime_error("the shared catalogue needs an address postgresql://USER@HOST/DATABASE");
  const std::string rest = address.substr(std::string(scheme).size());
  const std::string user = rest.substr(0, rest.find('/'));
  const bool has_password = user.find('@') != std::string::npos && user.find(':') < user.find('@');
  if (has_password || address.find("password=") != std::string::npos)
    throw std::runtime_error(
        "the address of the shared catalogue must hold no password, which others could read: "
        "put it into ~/.pgpass or PGPASSWORD");
}

class Connection {
 public:
  explicit Connection(const std::string& address) {
    const char* const drivers[] = {"PostgreSQL", nullptr};
    dataset_.reset(GDALDataset::Open(address.c_str(), GDAL_OF_VECTOR | GDAL_OF_UPDATE, drivers));
    if (!dataset_) fail("cannot be reached");
  }

  void run(const std::string& sql) {
    CPLErrorReset();
    if (OGRLayer* rows = dataset_->ExecuteSQL(sql.c_str(), nullptr, nullptr)) dataset_->ReleaseResultSet(rows);
    if (CPLGetLastErrorType() == CE_Failure) fail("refuses a statement");
  }
  [[nodiscard]] bool is_true(const std::string& condition) {
    OGRLayer* rows = dataset_->ExecuteSQL(("SELECT (" + condition + ")::int AS yes").c_str(), nullptr, nullptr);
    if (rows == nullptr) fail("refuses a question");
    const std::unique_ptr<OGRFeature> row(rows->GetNextFeature());
    const bool yes = row && row->GetFieldAsInteger(0) == 1;
    dataset_->ReleaseResultSet(rows);
    return yes;
  }
  void begin() {
    if (dataset_->StartTransaction() != OGRERR_NONE) fail("begins no transaction");
    run(lock);
  }
  void commit() {
    if (dataset_->CommitTransaction() != OGRERR_NONE) fail("does not commit");
  }
  [[nodiscard]] OGRLayer& layer(const char* name) {
    OGRLayer* found = dataset_->GetLayerByName(name);
    if (found == nullptr) fail("has no table of keyframes");
    return *found;
  }
  [[noreturn]] static void fail(const std::string& what) { throw host::gdal_error("the shared catalogue " + what); }

 private:
  host::Dataset dataset_;
};

void create(Connection& connection) {
  connection.begin();
  if (!connection.is_true("EXISTS (SELECT FROM pg_extension WHERE extname = 'postgis')"))
    connection.run("CREATE EXTENSION postgis");
  if (!connection.is_true("to_regclass('aerobot.keyframe') IS NOT NULL")) {
    connection.run("CREATE SCHEMA IF NOT EXISTS aerobot");
    connection.run(table_definition());
    connection.run("CREATE INDEX ON aerobot.keyframe USING gist(footprint)");
    connection.run(function);
  }
  connection.commit();
}

Shape outline_of(const intake::Keyframe& keyframe, const ExportedStrip& strip) {
  return {ShapeKind::polygon, footprint_of(keyframe, strip)};
}

void add_strip(OGRLayer& layer, const std::string& mission, const intake::Flight& flight, const ExportedStrip& strip,
               const Anchors* anchors) {
  const Georeference place = georeference_of(flight, strip.strip, anchors);
  const Placement placed(place);
  for (const std::int64_t id : strip.strip.keyframes) {
    const intake::Keyframe& keyframe = flight.keyframes.at(id);
    OGRFeature feature(layer.GetLayerDefn());
    feature.SetField("mission", mission.c_str());
    if (place.on_a_body()) feature.SetField("body", place.body.c_str());
    set_fields(feature, keyframe_row(keyframe, place.scale), feature.GetFieldIndex("keyframe"));
    const Shape outline = outline_of(keyframe, strip);
    if (outline.points.size() >= 3) feature.SetGeometryDirectly(geometry_of(outline, placed).release());
    if (layer.CreateFeature(&feature) != OGRERR_NONE) Connection::fail("refuses a keyframe");
  }
}

}  // namespace

void prepare_shared_catalogue(const std::string& address) {
  check_address(address);
  const host::GdalSession gdal;
  Connection connection(address);
  create(connection);
}

void write_shared_catalogue(const std::string& address, const std::string& mission, const intake::Flight& flight,
                            const std::vector<const ExportedStrip*>& strips, const Anchors* anchors) {
  check_address(address);
  const host::GdalSession gdal;
  Connection connection(address);
  OGRLayer& layer = connection.layer("aerobot.keyframe");
  connection.begin();
  connection.run("DELETE FROM aerobot.keyframe WHERE mission = " + quoted(mission));
  for (const ExportedStrip* strip : strips) add_strip(layer, mission, flight, *strip, anchors);
  if (layer.SyncToDisk() != OGRERR_NONE) Connection::fail("does not take the keyframes");
  connection.commit();
}

}  // namespace ilp::exports
