// Steps of a run that several processes do together: planning their work. The ordinary run (ground_run.hpp) ends it: it
// takes in what the tasks have left, and computes what is still missing.
#pragma once

#include "sim/ground/ground_run.hpp"
#include "sim/ground/tasks/work_package.hpp"

namespace ilp::ground {

/// Takes in what is new, and what earlier tasks have left, and writes packages (tasks/work_plan.hpp) for at most
/// `tasks` tasks. The kinds follow each other: looks, tiles, finish; what an earlier kind has left undone is done here.
/// Returns the number of packages. Throws as run_ground does.
std::size_t plan_work(const GroundOptions& options, tasks::WorkKind kind, std::size_t tasks, std::ostream& messages);

}  // namespace ilp::ground
