// ilp-ground merge OUTBOX --out DIR ...: the same results in tasks, on several processors or machines.
#pragma once

namespace ilp::ground {

/// Becomes the program that runs tasks (sim/tools/cluster/merge.py): it lies beside this one, or where the
/// package installs it (../share), or where the sources are when this one is in its build folder. `argv[1]` is "merge".
/// Returns only when it cannot be started.
int merge_main(int argc, char** argv);

}  // namespace ilp::ground
