#include "sim/ground/tasks/work_result.hpp"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "sim/ground/tasks/sealed_block.hpp"
#include "sim/host/digest.hpp"
#include "sim/host/files.hpp"

namespace ilp::tasks {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* extension = ".result";

WorkResult result_from(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  const auto bytes = read_block(stream);
  if (!bytes) throw std::runtime_error("empty");
  const json reported = json::from_cbor(*bytes);
  const auto kind = kind_of(reported.at("kind").get<std::string>());
  if (!kind) throw std::runtime_error("unknown kind of work");
  return {*kind,
          reported.at("owner").get<std::int64_t>(),
          {reported.at("column").get<std::int32_t>(), reported.at("row").get<std::int32_t>()},
          reported.at("digest").get<std::uint64_t>(),
          reported.at("summary").get_binary(),
          reported.at("cells").get_binary()};
}

void put(WorkResult result, intake::Catalogue& catalogue) {
  if (result.kind == WorkKind::quick_looks)
    return catalogue.put_quick_look(result.owner, result.digest, result.summary);
  const auto stage = result.kind == WorkKind::tiles ? intake::TileStage::painted : intake::TileStage::finished;
  catalogue.put({result.owner, result.place, stage}, result.digest, std::move(result.summary), std::move(result.cells));
}

std::vector<fs::path> results_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (it->path().extension() == extension) files.push_back(it->path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

fs::path work_folder(const fs::path& out) {
  return out / "work";
}

std::string name_of(WorkKind kind, std::int64_t owner, std::uint64_t digest) {
  return std::string(name_of(kind)) + "-" + std::to_string(owner) + "-" + host::digest_text(digest) + extension;
}

bool has_result(const fs::path& folder, const std::string& name) {
  std::error_code error;
  return fs::exists(folder / name, error);
}

void write_result(const WorkResult& result, const fs::path& folder) {
  const json reported = {{"kind", name_of(result.kind)},
                         {"owner", result.owner},
                         {"column", result.place.column},
                         {"row", result.place.row},
                         {"digest", result.digest},
                         {"summary", json::binary(result.summary)},
                         {"cells", json::binary(result.cells)}};
  std::ostringstream stream;
  write_block(stream, json::to_cbor(reported));
  host::write_file(folder / name_of(result.kind, result.owner, result.digest), stream.str());
}

TakenIn take_in_results(const fs::path& out, intake::Catalogue& catalogue,
                        const std::function<void(std::size_t, std::size_t)>& progress) {
  const std::vector<fs::path> files = results_in(work_folder(out) / "results");
  TakenIn taken;
  for (const fs::path& file : files) {
    try {
      put(result_from(file), catalogue);
      ++taken.results;
    } catch (const json::exception&) {
      ++taken.damaged;
    } catch (const std::runtime_error&) {
      ++taken.damaged;
    }
    fs::remove(file);
    if (progress) progress(taken.results + taken.damaged, files.size());
  }
  return taken;
}

}  // namespace ilp::tasks
