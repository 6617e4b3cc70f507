#include "bsp/flight/stage_set.hpp"

#include <cstring>

namespace ilp {
namespace {

bool is_name(const char* text, std::size_t length, const char* name) {
  return std::strlen(name) == length && std::strncmp(text, name, length) == 0;
}

StageMask stages_of(const char* text, std::size_t length) {
  if (is_name(text, length, "head")) return primary_stages;
  for (const Stage& stage : schedule) {
    if (stage.runs_on == RunsOn::any && is_name(text, length, stage.name)) return stage_bit(stage.component);
  }
  return 0;
}

}  // namespace

StageNames stage_names(StageMask stages) {
  StageNames names;
  if (is_primary(stages)) names.add("head");
  for (const Stage& stage : schedule) {
    if (!has_stage(stages, stage.component) || (is_primary(stages) && stage.runs_on == RunsOn::primary)) continue;
    if (names.size() > 0) names.add(',');
    names.add(stage.name);
  }
  return names;
}

bool parse_stages(const char* text, StageMask& stages, StageNames& culprit) {
  stages = 0;
  for (;;) {
    const std::size_t length = std::strcspn(text, ",");
    const StageMask named = stages_of(text, length);
    if (named == 0) {
      for (std::size_t i = 0; i < length; ++i) culprit.add(text[i]);
      return false;
    }
    stages |= named;
    if (text[length] == 0) return true;
    text += length + 1;
  }
}

}  // namespace ilp
