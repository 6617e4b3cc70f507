#include "sim/ground/export/raster_export.hpp"

#include <cpl_string.h>
#include <cpl_vsi.h>
#include <gdal_priv.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <ostream>
#include <system_error>

#include "sim/ground/export/raster_block.hpp"
#include "sim/ground/map/damaged_catalogue.hpp"
#include "sim/host/files.hpp"
#include "sim/host/gdal_session.hpp"
#include "sim/host/parallel.hpp"

namespace ilp::exports {
namespace {
namespace fs = std::filesystem;

using Keys = std::vector<std::vector<std::uint64_t>>;  ///< by level and block

struct BandInfo {
  const char* name;
  GDALDataType type;
  double nodata;
  std::string unit, description;
};

std::vector<BandInfo> bands(const Georeference& place) {
  return {{"height", GDT_Float32, HeightSample::nothing, place.unit, place.height_name},
          {"sigma", GDT_Float32, HeightSample::nothing, place.unit,
           "one sigma of the height: matching, poses, scale, tilt and place together, as far as they are stated"},
          {"sigma-matching", GDT_Float32, HeightSample::nothing, place.unit, "the part of one sigma from matching"},
          {"count", GDT_UInt16, CountSample::nothing, "keyframes", "keyframes whose surface covers the cell"},
          {"ortho", GDT_Byte, GreySample::nothing, "grey value", "seen from above"},
          {"laid", GDT_Byte, GreySample::nothing, "grey value",
           "seen from above where no height was measured, laid on interpolated heights"}};
}

struct BlockSamples {
  std::vector<float> height = std::vector<float>(block_samples, HeightSample::nothing), sigma = height,
                     matching = height;
  std::vector<std::uint16_t> count = std::vector<std::uint16_t>(block_samples, CountSample::nothing);
  std::vector<std::uint8_t> ortho = std::vector<std::uint8_t>(block_samples, GreySample::nothing), laid = ortho;
};

void put_cell(const map::Mosaic& mosaic, const map::MapTile& tile, std::int32_t column, std::int32_t row,
              const Georeference& place, std::size_t to, BlockSamples& out) {
  const std::size_t from = tile.height.index(column - tile.column, row - tile.row);
  const float z = tile.height.samples[from];
  if (!std::isfinite(z)) {
    if (!tile.laid.grey.empty()) out.laid[to] = tile.laid.grey.samples[from];
    return;
  }
  out.height[to] = static_cast<float>(place.height_of(z));
  if (!tile.sigma.empty() && std::isfinite(tile.sigma.samples[from])) {
    const map::MapGeometry& map = mosaic.geometry;
    const Vec3 point(map.x0 + column * map.cell, map.y0 - row * map.cell, z);
    const std::uint16_t source = tile.source.empty() ? std::uint16_t{0} : tile.source.samples[from];
    out.sigma[to] =
        static_cast<float>(place.scale * mosaic.errors.parts(point, source, tile.sigma.samples[from]).whole());
    out.matching[to] = static_cast<float>(place.scale * tile.sigma.samples[from]);
  }
  out.count[to] = std::min<std::uint16_t>(tile.count.samples[from], CountSample::nothing - 1);
  out.ortho[to] = std::max<std::uint8_t>(tile.ortho.samples[from], 1);
}

void check_size(const map::Mosaic& mosaic, const map::MapTile& tile) {
  const std::int32_t w = tile.height.width, h = tile.height.height;
  const auto fits = [&](const auto& raster) { return raster.same_size(w, h); };
  const bool inside = tile.column >= 0 && tile.row >= 0 && w > 0 && h > 0 &&
                      tile.column <= mosaic.geometry.columns - w && tile.row <= mosaic.geometry.rows - h;
  if (!inside || !fits(tile.ortho) || !fits(tile.count) || !(tile.sigma.empty() || fits(tile.sigma)) ||
      !(tile.laid.grey.empty() || fits(tile.laid.grey))) {
    throw std::logic_error("a tile that does not fit its map");
  }
}

/// The blocks of all bands. Those that `kept` has are not computed again.
class Blocks {
 public:
  Blocks(const map::Mosaic& mosaic, const Georeference& place, intake::ResultCache& kept)
      : mosaic_(mosaic),
        place_(place),
        kept_(kept),
        levels_(cloud_levels(mosaic.geometry.columns, mosaic.geometry.rows)) {
    for (std::size_t band = 0; band < band_count; ++band) {
      bands_[band].levels = levels_;
      for (const CloudLevel& level : levels_) bands_[band].keys.emplace_back(level.blocks(), 0);
    }
    statistics_.resize(band_count * levels_.front().blocks());
  }

  void compute() {
    host::for_each_parallel(levels_.front().blocks(), [&](std::size_t block) { compute_block(block); });
    for (std::size_t level = 1; level < levels_.size(); ++level) {
      host::for_each_parallel(levels_[level].blocks(), [&](std::size_t block) {
        halve<HeightSample>(0, level, block);
        halve<HeightSample>(1, level, block);
        halve<HeightSample>(2, level, block);
        halve<CountSample>(3, level, block);
        halve<GreySample>(4, level, block);
        halve<GreySample>(5, level, block);
      });
    }
  }

  [[nodiscard]] SampleStatistics statistics(std::size_t band) const {
    SampleStatistics all;
    for (std::size_t block = 0; block < levels_.front().blocks(); ++block)
      all.add(statistics_[block * band_count + band]);
    return all;
  }

  void write(std::size_t band, std::span<const std::uint8_t> head, std::ostream& out) const {
    write_cloud_tiff(
        head, bands_[band].levels,
        [&](std::size_t level, std::size_t number) { return known(bands_[band].keys[level][number]).coded; }, out);
  }

  static constexpr std::size_t band_count = 6, whole_sigma_band = 1;

 private:
  struct Band {
    std::vector<CloudLevel> levels;
    Keys keys;  ///< 0: nothing there
  };

  [[nodiscard]] std::optional<RasterBlock> find(std::uint64_t key) const {
    const auto bytes = kept_.result(key);
    return bytes ? raster_block_from(*bytes) : std::nullopt;
  }
  [[nodiscard]] RasterBlock known(std::uint64_t key) const {
    auto block = find(key);
    if (!block) throw map::DamagedCatalogue("a block of the map cannot be read back");
    return std::move(*block);
  }

  void note(std::size_t band, std::size_t level, std::size_t number, std::uint64_t key, const RasterBlock& block) {
    if (level == 0) statistics_[number * band_count + band] = block.statistics;
    if (block.coded.empty()) return;
    bands_[band].keys[level][number] = key;
    bands_[band].levels[level].block_bytes[number] = static_cast<std::uint32_t>(block.coded.size());
  }

  /// Columns and rows of tiles that lie over cells of the map.
  struct TileRange {
    std::int32_t left = 0, top = 0, right = -1, bottom = -1;
  };
  [[nodiscard]] TileRange tiles_over(std::int32_t x, std::int32_t y) const {
    const auto tile = [&](std::int32_t cell, std::int32_t first, std::int32_t tiles) {
      return std::clamp((cell - first) / mosaic_.tile_side, 0, tiles - 1);
    };
    const std::int32_t last_x = std::min(x + cloud_block_side, mosaic_.geometry.columns) - 1,
                       last_y = std::min(y + cloud_block_side, mosaic_.geometry.rows) - 1;
    return {tile(x, mosaic_.left, mosaic_.tile_columns), tile(y, mosaic_.top, mosaic_.tile_rows),
            tile(last_x, mosaic_.left, mosaic_.tile_columns), tile(last_y, mosaic_.top, mosaic_.tile_rows)};
  }

  /// Of all that the block depends on; none where no tile has any data.
  [[nodiscard]] std::optional<std::uint64_t> digest_of(std::int32_t x, std::int32_t y) const {
    intake::InputDigest digest("block of a raster 3");
    digest.add_value(place_.scale).add_value(place_.height_of(0)).add_value(mosaic_.tile_side);
    bool any = false;
    const TileRange tiles = tiles_over(x, y);
    for (std::int32_t row = tiles.top; row <= tiles.bottom; ++row) {
      for (std::int32_t column = tiles.left; column <= tiles.right; ++column) {
        const std::optional<std::uint64_t> tile = mosaic_.digest(column, row);
        if (!tile) continue;
        any = true;
        digest.add_value(mosaic_.left + column * mosaic_.tile_side - x);
        digest.add_value(mosaic_.top + row * mosaic_.tile_side - y).add_value(*tile);
      }
    }
    return any ? std::optional(digest.value()) : std::nullopt;
  }

  [[nodiscard]] BlockSamples samples_of(std::int32_t x, std::int32_t y) const {
    BlockSamples samples;
    const TileRange tiles = tiles_over(x, y);
    for (std::int32_t row = tiles.top; row <= tiles.bottom; ++row) {
      for (std::int32_t column = tiles.left; column <= tiles.right; ++column) {
        const std::optional<map::MapTile> tile = mosaic_.tile(column, row);
        if (!tile) continue;
        check_size(mosaic_, *tile);
        put_tile(*tile, x, y, samples);
      }
    }
    return samples;
  }

  void put_tile(const map::MapTile& tile, std::int32_t x, std::int32_t y, BlockSamples& samples) const {
    const std::int32_t left = std::max(x, tile.column), top = std::max(y, tile.row);
    const std::int32_t right = std::min(x + cloud_block_side, tile.column + tile.height.width),
                       bottom = std::min(y + cloud_block_side, tile.row + tile.height.height);
    for (std::int32_t row = top; row < bottom; ++row) {
      for (std::int32_t column = left; column < right; ++column) {
        const auto to = static_cast<std::size_t>(row - y) * cloud_block_side + static_cast<std::size_t>(column - x);
        put_cell(mosaic_, tile, column, row, place_, to, samples);
      }
    }
  }

  void compute_block(std::size_t number) {
    const auto columns = static_cast<std::size_t>(levels_.front().block_columns());
    const std::int32_t x = static_cast<std::int32_t>(number % columns) * cloud_block_side,
                       y = static_cast<std::int32_t>(number / columns) * cloud_block_side;
    const std::optional<std::uint64_t> digest = digest_of(x, y);
    if (!digest) return;
    const auto key_of = [&](std::size_t band) {
      intake::InputDigest key("band");
      key.add_value(*digest).add_value(band);
      // Of all bands only the whole error depends on more than the tiles.
      if (band == whole_sigma_band) {
        const map::MapGeometry& map = mosaic_.geometry;
        key.add_value(mosaic_.errors.digest()).add_value(map.x0 + x * map.cell).add_value(map.y0 - y * map.cell);
      }
      return key.value();
    };
    std::array<std::optional<RasterBlock>, band_count> blocks;
    bool all_known = true;
    for (std::size_t band = 0; band < band_count; ++band) {
      blocks[band] = find(key_of(band));
      all_known = all_known && blocks[band];
    }
    if (!all_known) {
      const BlockSamples samples = samples_of(x, y);
      blocks = {raster_block<HeightSample>(samples.height),   raster_block<HeightSample>(samples.sigma),
                raster_block<HeightSample>(samples.matching), raster_block<CountSample>(samples.count),
                raster_block<GreySample>(samples.ortho),      raster_block<GreySample>(samples.laid)};
      for (std::size_t band = 0; band < band_count; ++band) kept_.put_result(key_of(band), bytes_of(*blocks[band]));
    }
    for (std::size_t band = 0; band < band_count; ++band) note(band, 0, number, key_of(band), *blocks[band]);
  }

  /// A block of an overview, from the four of the level before.
  template <typename Sample>
  void halve(std::size_t band, std::size_t level, std::size_t number) {
    const auto columns = static_cast<std::size_t>(levels_[level].block_columns()),
               finer_columns = static_cast<std::size_t>(levels_[level - 1].block_columns()),
               finer_rows = static_cast<std::size_t>(levels_[level - 1].block_rows());
    std::array<std::uint64_t, 4> finer{};
    for (std::size_t i = 0; i < finer.size(); ++i) {
      const std::size_t column = 2 * (number % columns) + i % 2, row = 2 * (number / columns) + i / 2;
      if (column < finer_columns && row < finer_rows)
        finer[i] = bands_[band].keys[level - 1][row * finer_columns + column];
    }
    if (std::all_of(finer.begin(), finer.end(), [](std::uint64_t key) { return key == 0; })) return;
    intake::InputDigest digest("block of an overview 1");
    for (const std::uint64_t key : finer) digest.add_value(key);
    std::optional<RasterBlock> block = find(digest.value());
    if (!block) {
      std::vector<typename Sample::Type> samples(block_samples, Sample::nothing);
      for (std::size_t i = 0; i < finer.size(); ++i) {
        if (finer[i] == 0) continue;
        put_halved<Sample>(known(finer[i]).halved, static_cast<std::int32_t>(i % 2), static_cast<std::int32_t>(i / 2),
                           samples);
      }
      block = raster_block<Sample>(samples);
      kept_.put_result(digest.value(), bytes_of(*block));
    }
    note(band, level, number, digest.value(), *block);
  }

  const map::Mosaic& mosaic_;
  const Georeference& place_;
  intake::ResultCache& kept_;
  std::vector<CloudLevel> levels_;
  std::array<Band, band_count> bands_;
  std::vector<SampleStatistics> statistics_;  ///< by block and band
};

/// Everything that a file says beside its samples, by GDAL.
std::vector<std::uint8_t> head_of(const BandInfo& info, const map::Mosaic& mosaic, const Georeference& place,
                                  const SampleStatistics& statistics, const fs::path& path) {
  constexpr const char* name = "/vsimem/ilp-head-of-a-raster.tif";
  CPLStringList options;
  options.SetNameValue("TILED", "YES");
  options.SetNameValue("BLOCKXSIZE", "256");
  options.SetNameValue("BLOCKYSIZE", "256");
  options.SetNameValue("COMPRESS", "DEFLATE");
  options.SetNameValue("PREDICTOR", info.type == GDT_Float32 ? "3" : "2");
  options.SetNameValue("SPARSE_OK", "TRUE");
  options.SetNameValue("BIGTIFF", "NO");
  options.SetNameValue("ENDIANNESS", "LITTLE");
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  host::Dataset file(driver->Create(name, cloud_block_side, cloud_block_side, 1, info.type, options.List()));
  std::array<double, 6> transform = geotransform(place, mosaic.geometry);
  GDALRasterBand* const band = file ? file->GetRasterBand(1) : nullptr;
  const auto count = static_cast<double>(statistics.count);
  const std::string crs = place.raster_crs();
  if (!file || file->SetGeoTransform(transform.data()) != CE_None ||
      (!crs.empty() && file->SetProjection(crs.c_str()) != CE_None) || band->SetNoDataValue(info.nodata) != CE_None ||
      band->SetStatistics(statistics.least, statistics.most, statistics.mean, std::sqrt(statistics.squares / count)) !=
          CE_None) {
    throw host::gdal_error("cannot write " + path.string());
  }
  const double cells = static_cast<double>(mosaic.geometry.columns) * mosaic.geometry.rows;
  band->SetMetadataItem("STATISTICS_VALID_PERCENT", CPLSPrintf("%.4g", 100 * count / cells));
  band->SetUnitType(info.unit.c_str());
  band->SetDescription(info.description.c_str());
  file->SetMetadataItem("TIFFTAG_SOFTWARE", "ilp-ground");
  file->SetMetadataItem("TIFFTAG_IMAGEDESCRIPTION", (info.description + "; " + place.sentence).c_str());
  file.reset();
  vsi_l_offset bytes = 0;
  const std::unique_ptr<GByte, decltype(&VSIFree)> held(VSIGetMemFileBuffer(name, &bytes, true), &VSIFree);
  if (!held) throw host::gdal_error("cannot write " + path.string());
  return {held.get(), held.get() + bytes};
}

/// By what is in them, where the map does not say it.
map::Mosaic with_digests(const map::Mosaic& mosaic) {
  if (mosaic.digest) return mosaic;
  map::Mosaic out = mosaic;
  out.digest = [tile = mosaic.tile](std::int32_t column, std::int32_t row) -> std::optional<std::uint64_t> {
    const std::optional<map::MapTile> found = tile(column, row);
    if (!found) return std::nullopt;
    intake::InputDigest digest("tile");
    const auto add = [&](const auto& raster) {
      digest.add({reinterpret_cast<const std::uint8_t*>(raster.samples.data()),
                  raster.samples.size() * sizeof(raster.samples[0])});
    };
    add(found->height);
    add(found->sigma);
    add(found->ortho);
    add(found->count);
    add(found->laid.grey);
    return digest.value();
  };
  return out;
}

}  // namespace

std::vector<std::string> write_rasters(const map::Mosaic& given, const Georeference& place, const std::string& suffix,
                                       const fs::path& folder, intake::ResultCache* kept) {
  const host::GdalSession gdal;
  if (given.tile_side <= 0) throw std::logic_error("a map whose tiles have no size");
  const map::Mosaic mosaic = with_digests(given);
  intake::MemoryResultCache own;
  Blocks blocks(mosaic, place, kept != nullptr ? *kept : own);
  blocks.compute();
  std::vector<std::string> names;
  const std::vector<BandInfo> all = bands(place);
  if (blocks.statistics(0).count == 0) throw std::runtime_error("a map on which nothing was seen");
  for (std::size_t band = 0; band < all.size(); ++band) {
    const std::string name = all[band].name + suffix + ".tif";
    const SampleStatistics statistics = blocks.statistics(band);
    if (statistics.count == 0) {
      std::error_code ignored;
      fs::remove(folder / name, ignored);
      continue;
    }
    const std::vector<std::uint8_t> head = head_of(all[band], mosaic, place, statistics, folder / name);
    host::update_file(folder / name, [&](std::ostream& out) { blocks.write(band, head, out); });
    names.push_back(name);
  }
  return names;
}

host::Raster<std::uint8_t> read_ortho(const fs::path& file, std::int32_t max_side) {
  const host::GdalSession gdal;
  const host::Dataset dataset(GDALDataset::Open(file.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!dataset) throw host::gdal_error("cannot read " + file.string());
  const std::int32_t columns = dataset->GetRasterXSize(), rows = dataset->GetRasterYSize();
  const double shrink = std::max(1.0, static_cast<double>(std::max(columns, rows)) / max_side);
  const auto shrunk = [&](std::int32_t side) { return std::max(1, static_cast<std::int32_t>(side / shrink)); };
  host::Raster<std::uint8_t> texture(shrunk(columns), shrunk(rows));
  GDALRasterIOExtraArg how;
  INIT_RASTERIO_EXTRA_ARG(how);
  how.eResampleAlg = GRIORA_Average;
  if (dataset->GetRasterBand(1)->RasterIO(GF_Read, 0, 0, columns, rows, texture.samples.data(), texture.width,
                                          texture.height, GDT_Byte, 0, 0, &how) != CE_None) {
    throw host::gdal_error("cannot read " + file.string());
  }
  return texture;
}

}  // namespace ilp::exports
