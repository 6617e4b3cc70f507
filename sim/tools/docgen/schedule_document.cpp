#include "sim/tools/docgen/schedule_document.hpp"

#include "cfg/schedule.hpp"
#include "fsw/records/records.hpp"
#include "sim/tools/docgen/markdown.hpp"

namespace ilp::docgen {
namespace {

std::string names_of(RecordMask mask, const char* quote, const char* every) {
  constexpr RecordMask every_table = mask_of(RecordType::count) - 1;
  if (mask == every_table) return every;
  std::string names;
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    const auto type = static_cast<RecordType>(t);
    if ((mask & mask_of(type)) == 0) continue;
    names += (names.empty() ? "" : ", ") + std::string(quote) + record_info(type).name + quote;
  }
  return names;
}

std::string milliseconds(TimeNs time) {
  return number(static_cast<double>(time) / static_cast<double>(ns_per_ms)) + " ms";
}

std::string runs(const Stage& stage) {
  if (stage.period == 0) return "when woken";
  const std::string every =
      stage.period == 1 ? "every minor frame" : "every " + std::to_string(stage.period) + " minor frames";
  return stage.wakes == 0 || stage.period == 1 ? every : "when woken, and " + every;
}

std::string state(const StateLayout& state) {
  std::string text = std::to_string(state.number);
  if (state.second != 0) text += " or " + std::to_string(state.second);
  return text + (state.old == OldState::dropped ? ", an old one is dropped" : "");
}

Cells cells_of(const Stage& stage) {
  const auto tables = [](RecordMask mask) { return names_of(mask, "`", "every table"); };
  return {code(stage.name),      tables(stage.wakes),  tables(stage.reads), tables(stage.writes),
          tables(stage.changes), tables(stage.erases), runs(stage),         milliseconds(stage.budget_ns)};
}

const Cells titles = {"stage", "woken by", "reads", "makes", "changes", "erases", "runs", "budget"};

/// What the picture leaves out: these wake many, or belong to the ground's side.
bool drawn(const Stage& stage) {
  const std::size_t place = place_of(stage.component);
  return place >= place_of(ComponentId::capture_clock) && place <= place_of(ComponentId::file_delivery);
}

}  // namespace

std::string stages_of(const std::string& page) {
  std::string text = table_head(titles);
  for (const Stage& stage : schedule) {
    if (page == stage.page) text += table_row(cells_of(stage));
  }
  return text;
}

std::string schedule_picture() {
  constexpr RecordMask of_many = mask_of(RecordType::command, RecordType::setting);
  std::string text = "```mermaid\nflowchart LR\n";
  for (const Stage& maker : schedule) {
    for (const Stage& woken : schedule) {
      const RecordMask records = maker.writes & woken.wakes & ~of_many;
      if (records == 0 || !drawn(maker) || !drawn(woken) || maker.component == woken.component) continue;
      text += "  " + std::string(maker.name) + " -- \"" + names_of(records, "", "") + "\" --> " + woken.name + "\n";
    }
  }
  return text + "  downlink -- transfer --> file_delivery\n```\n";
}

std::string schedule_document() {
  std::string text =
      "The executive runs in minor frames of " + milliseconds(minor_frame_ns) +
      ". In each it calls, in the order of data flow ([picture](design.md#the-picture)) and of the table, every "
      "component that is due or was woken by a change of a table that it watches; the rest of the frame goes to "
      "components with work pending. A step over its budget is an overrun and is not cut off. At most " +
      std::to_string(max_steps_per_frame) + " steps run in one frame. A component that reports " +
      std::to_string(max_faults_in_a_row) +
      " faults without a good step between them waits for the next frame.\n\n"
      "The page under *tables* says what wakes the component and which tables it reads, *makes* (its own) and "
      "*changes* "
      "(another's); the compiler refuses any other call (`hal/store/store_view.hpp`, `fsw/executive/stage_component.hpp"
      "`). Each table has one maker, but for `command`, which several number within their transaction. Every component "
      "writes its `checkpoint`, the executive `event`, `component` and `timing`, the start of a flight `start`, "
      "`identity` and the first `camera`, each process of a shared flight its `node`.\n\n";
  text += table_head({"no.", "stage", "runs", "budget", "layout of its state", "process", "tables"});
  for (const Stage& stage : schedule) {
    const std::string page = stage.page;
    const char* const process = stage.runs_on == RunsOn::primary ? "primary" : "any";
    text += table_row({std::to_string(static_cast<unsigned>(stage.component)), code(stage.name), runs(stage),
                       milliseconds(stage.budget_ns), state(stage.state), process,
                       "[" + page + "](../fsw/" + page + "/design.md)"});
  }
  return text +
         "\nThe number is permanent, and the id of the component's rows in `component` and `checkpoint`. *Process*: "
         "any "
         "of those that share a flight, or the primary, which has camera and links "
         "([several-machines.md](several-machines.md)).\n";
}

}  // namespace ilp::docgen
