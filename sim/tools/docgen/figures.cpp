#include "sim/tools/docgen/figures.hpp"

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "sim/host/files.hpp"
#include "sim/tools/docgen/markdown.hpp"

namespace ilp::docgen {
namespace {

using Json = nlohmann::json;

struct Block {
  std::string name;
  std::size_t begin, end;  ///< of what stands between the two lines, in the page
};

std::vector<Block> blocks_of(const std::string& page) {
  const std::string head = "<!-- figures: ", close = " -->\n", tail = "<!-- end -->";
  std::vector<Block> blocks;
  for (std::size_t at = page.find(head); at != std::string::npos; at = page.find(head, at)) {
    const std::size_t name = at + head.size(), line_end = page.find(close, name), end = page.find(tail, name);
    if (end == std::string::npos || line_end > end || page.find(head, name) < end) {
      throw std::runtime_error("the block \"" + page.substr(at, page.find('\n', at) - at) + "\" has no \"" + tail +
                               "\"");
    }
    blocks.push_back({page.substr(name, line_end - name), line_end + close.size(), end});
    at = end;
  }
  return blocks;
}

std::string title(const Json& column) {
  const std::string name = column.at("name"), unit = column.value("unit", "");
  return cell(unit.empty() ? name : name + ", " + unit);
}

std::string table(const Json& figures) {
  std::string text;
  for (const Json& line : figures.at("command")) text += "    " + line.get<std::string>() + "\n";
  if (text.empty()) throw std::runtime_error("\"command\" is empty: name the commands that measure the figures");
  Cells titles;
  for (const Json& column : figures.at("columns")) titles.push_back(title(column));
  text += "\n" + table_row(titles) + "|";
  for (std::size_t i = 0; i < titles.size(); ++i) text += "---|";
  text += "\n";
  for (const Json& row : figures.at("rows")) {
    if (row.size() != titles.size())
      throw std::runtime_error("the row " + row.dump() + " must have one text for each column");
    Cells cells;
    for (const Json& text_of_cell : row) cells.push_back(cell(text_of_cell));
    text += table_row(cells);
  }
  return text;
}

}  // namespace

std::string figures_table(const std::filesystem::path& file) {
  const std::vector<std::uint8_t> bytes = host::read_file(file);
  try {
    return table(Json::parse(bytes));
  } catch (const std::exception& error) {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
}

std::vector<std::string> figures_of(const std::string& page) {
  std::vector<std::string> names;
  for (const Block& block : blocks_of(page)) names.push_back(block.name);
  return names;
}

std::string with_figures(const std::string& page, const std::filesystem::path& folder) {
  std::string text;
  std::size_t done = 0;
  for (const Block& block : blocks_of(page)) {
    text += page.substr(done, block.begin - done) + "\n" + figures_table(folder / (block.name + ".json")) + "\n";
    done = block.end;
  }
  return text + page.substr(done);
}

}  // namespace ilp::docgen
