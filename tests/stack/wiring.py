"""What the flight calls through pointers and virtual functions, listed by hand; a library's calls are told by the names
that Debian 12 has (SQLite 3.40, OpenJPEG 2.5.0, libjpeg-turbo 2.1.5, glibc 2.36). libraries.txt bounds recursion."""
import re

SQLITE_VERSION = b"3.40.1"
# Of the stack of a thread: what the C library keeps at its beginning, and what the kernel puts on it for a signal, with
# the registers of the largest processor, and the handler
THREAD_BYTES = 4096
SIGNAL_BYTES = 12288
# The C library's functions where it is loaded, more than the static programs say; and what these choose by the processor
C_LIBRARY_BYTES = [(re.compile(r"\*ABS\*|\.plt|_*mem|str(len|n?cmp|n?cpy|r?chr)"), 256),
                   (re.compile(r".*(printf|scanf|error)"), 32768), (re.compile(r""), 8192)]
# What a function takes by an amount that is known at run time only, at most.
DYNAMIC_BYTES = {
    "__printf_fp_l": 6144,           # digits of a double, three times, and its text
    "__mpn_mul": 2048,               # a product of such numbers
    "printf_positional": 2048,       # arguments that a format numbers: there is none
    "__dcigettext": 1024,            # names of a domain and a language: no domain is set
    "__sysconf_check_spec": 256,     # a name of the system's
    "__vfscanf_internal": 1024,      # a word of a file
    "____longjmp_chk": 0, "__longjmp": 0,  # goes back to the stack of setjmp
}


class Calls:
    """Functions that match `callers` call the functions of `callees`: a name of an interface or a class stands for all
    its virtual functions, anything else is an expression for names."""

    def __init__(self, callers, callees, reason):
        self.pattern, self.callees, self.reason = re.compile(callers), tuple(callees), reason


def one_of(words):
    return "(" + "|".join(words.split()) + ")"


def snake_case(name):
    return re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()


LOCAL = r"ilp::\(anonymous namespace\)::"
STAGES = ("Acquisition CameraCalibrator CaptureClock Compressor DenseMatcher Downlink FileDelivery MapFix Navigator "
          "OverlapChecker PlaceMemory RichnessScorer Scrubber StorageManager StructureAndMotion TelecommandGuard "
          "Telecommander TelemetryReporter")
PARTS = ("DownlinkChoice DownlinkConfirmations DownlinkFiles FileDeliveryLink FileDeliveryPart FileDeliveryRecords "
         "LensSearch MapPart MapStart PlaceLinks PlaceMarks PlacePart PlaceRecall StorageProducts StorageRelease StripCheck")
# Interfaces, and the classes that have their functions
INTERFACES = {
    "Component": STAGES,
    "Camera": "DirectoryCamera HeldCamera NoCamera V4l2Camera Y4mCamera",
    "Clock": "RealClock VirtualClock",
    "Compute": "CpuCompute GuardedCompute",
    "ComputeDevice": "SharedCompute",
    "DiskWait": "WatchedWait",
    "Health": "Executive",
    "ImageSource": "RecordedStrip StreamSource VideoSource",
    "Link": "DeliveryQueue NoLink OutboxLink CommittedLink",
    "MapFolder": "DirectoryMapSource",
    "MapSource": "DirectoryMapSource",
    "NavigationSource": "NavigationFile VehiclePackets",
    "Nonvolatile": "FileNonvolatile RamNonvolatile",
    "PacketLink": "JoinedLink CommittedPacketLink TcpLink UdpLink",
    "Store": "ImageCache LeasedStore PostgresStore RamStore SharedFlightStore ValidStore SqliteStore StepStore",
    "StoreSharing": "FlightStore PostgresStore",
    "VideoDevice": "LinuxVideoDevice",
    "Watchdog": "LinuxWatchdog NullWatchdog",
    "Worker": "InlineWorker ThreadWorker",
}
# Threads, and what each of them begins with
THREADS = {"flight": rf"{LOCAL}run\(void\*\)", "worker": r"ilp::ThreadWorker::enter\(void\*\)",
           "disk": r"ilp::DiskProbe::enter\(void\*\)"}
# Of the flight, and called by the C library or a library that is loaded
CALLED_FROM_OUTSIDE = [
    rf"{LOCAL}end_process\(int\)|\(anonymous namespace\)::request_stop\(int\)",  # signals: SIGNAL_BYTES
    r"ilp::postgres::\(anonymous namespace\)::(ignore_notice|keep_gate_open)\(.*",  # libpq, and the end of the process
    r".*::~\w+\(\)",                                                              # the end of the process
    r"ilp::PacketLink::accept_sender\(\)",                                        # every link has its own
]

SQLITE_IO = ("Close Read Write Truncate Sync FileSize Lock Unlock CheckReservedLock FileControl SectorSize "
             "DeviceCharacteristics ShmMap ShmLock ShmBarrier ShmUnmap Fetch Unfetch")
UNIX_VFS = r"unix(Open|Delete|Access|FullPathname|Dl\w+|Randomness|Sleep|CurrentTime\w*|GetLastError)"

# The first row that matches a caller holds.
FLIGHT = [
    # Threads, the heap's gate, and calls that may be abandoned
    Calls(rf"{LOCAL}run\(void\*\)", [r"\(anonymous namespace\)::fly\(void\*\)"], "call_on_flight_stack: main's body"),
    Calls(r"ilp::(ThreadWorker::work|InlineWorker::)", [r"ilp::code_product\(void\*\)"], "WorkerJob: the compressor's"),
    Calls(r"ilp::(HeapGateScope::|heap_region_exhausted)", [rf"{LOCAL}(enter|leave|region)_\w+\(ilp::HeapRegion\)"],
          "HeapGateHooks of bsp/memory/flight_heap.cpp"),
    Calls(r"ilp::(call_in_heap_region|call_abandonable)\(", [rf"{LOCAL}((de|en)code_call|decode|read_rows)\(void\*\)"],
          "calls of OpenJPEG and libjpeg"),
    # What stands before another one of its kind
    Calls(r"ilp::(ForwardingStore|StepStore|ImageCache|ValidStore|LeasedStore|SharedFlightStore)::",
          ["Store", "StoreSharing"], "the store behind it"),
    Calls(r"ilp::CommittedLink::", ["NoLink", "DeliveryQueue", "OutboxLink", "StoreSharing"], "the link behind it"),
    Calls(r"ilp::CommittedPacketLink::", ["JoinedLink", "TcpLink", "UdpLink", "StoreSharing"], "the link behind it"),
    Calls(r"ilp::JoinedLink::", ["TcpLink", "UdpLink"], "the two links behind it"),
    Calls(r"ilp::HeldCamera::", ["NoCamera", "DirectoryCamera", "V4l2Camera", "Y4mCamera", "Store"],
          "the camera behind it"),
    Calls(r"ilp::Camera::", ["NoCamera", "DirectoryCamera", "V4l2Camera", "Y4mCamera"], "its own other functions"),
    # Functions in tables and parameters
    Calls(r"ilp::serve_functions\(", [rf"{LOCAL}\w+\({LOCAL}ActiveFunction&\)", "Store", "Clock"], "effects"),
    Calls(rf"ilp::Telecommander::(carry_out|perform)\(|{LOCAL}serve\(",
          [r"ilp::serve_\w+\(ilp::ServiceCall&\)", "Store", "Clock"], "find_service"),
    Calls(r"ilp::TelemetryReporter::step\(",
          [r"ilp::TelemetryReporter::(obey_commands|report_events|save_cursor|send_due)\(\)", "Store", "Clock"],
          "the parts of a step"),
    Calls(r"ilp::(VehiclePackets::|encode_navigation_packet|NavigationFile::)",
          [rf"{LOCAL}columns::\{{lambda.*", "PacketLink", "Clock"], "NavigationColumn::value; the link"),
    Calls(rf"{LOCAL}(run_decoder|decode_call)\(", [rf"{LOCAL}measure<.*", r"ilp::decode_jpeg2000.*::\{lambda.*"],
          "DecodeCall::take"),
    Calls(r"ilp::CpuCompute::", [rf"{LOCAL}(match|search)_unit\(.*"], "ComputeForm::compute"),
    Calls(r"ilp::GuardedCompute::",
          ["ComputeDevice", "CpuCompute", rf"{LOCAL}((match|search)_unit|write_example)\(.*", "Clock"],
          "ComputeForm; the device"),
    Calls(r"ilp::DirectoryCamera::", [rf"{LOCAL}decode\w*\(char const\*.*"], "DecodeImage"),
    Calls(r"ilp::LinuxWatchdog::", [rf"{LOCAL}kernel_calls::\{{lambda.*"], "WatchdogCalls"),
    Calls(r"ilp::postgres::|.*add_table_definition",
          [r"ilp::postgres::(look_at_changes|note_changes|used_bytes)\(ilp::FixedText.*",
           r"ilp::(postgres::)?\(anonymous namespace\)::sql_type\(.*"], "texts of statements, types of columns"),
    # SQLite's files, with checksums (hal/store/sqlite/checked_vfs.cpp)
    Calls(r"ilp::sqlite::(\(anonymous namespace\)::)?(synchronise|flush\()", [rf"{LOCAL}on_sync\(sqlite3_file\*.*"],
          "the file of the database"),
    Calls(r"ilp::sqlite::on_busy\(", ["unixSleep"], "sqlite3_vfs.xSleep"),
    Calls(rf"{LOCAL}\w+\((sqlite3_file\*|{LOCAL}CheckedFile&)", [rf"(unix|dotlock|nolock){one_of(SQLITE_IO)}"],
          "SQLite's own functions for a file"),
    Calls(rf"{LOCAL}\w+\(sqlite3_vfs\*", [UNIX_VFS], "SQLite's own functions for files"),
    # The executive, stages and their parts
    Calls(rf"ilp::Executive::|.*\(.*({LOCAL}Frame|ilp::ComponentTable)\b",
          ["Component", r"ilp::Component::lasting\(\).*", "Store", "Clock"], "fsw/executive"),
    Calls(rf"ilp::{one_of(STAGES + ' ' + PARTS)}::",
          ["Store", "Clock", "Camera", "Compute", "Link", "MapSource", "PacketLink", "NavigationSource", "Worker", "Health",
           "Nonvolatile"], "what stages are given"),
    Calls(r"(ilp::Status )?ilp::OutgoingFile::", ["Store", "Link"], "records and the link that they go by"),
    Calls(r"ilp::(EventLog|Uplink|VictimSearch|DeliveryQueue)::", ["Store", "Clock"], "records"),
    Calls(r"ilp::(BandJobs|WideOverlap)::", ["Compute"], "jobs"),
    Calls(r"ilp::(TelemetryWriter|PacketRouter)::", ["PacketLink", "Clock"], "packets"),
    Calls(r"ilp::FlightMemory::", ["Nonvolatile"], "the memory that outlives a database"),
    Calls(r"ilp::(BufferPool|V4l2Camera)::", ["VideoDevice", "Clock"], "the driver"),
    Calls(r"ilp::(TcpLink|UdpLink)::", ["Clock"], "times of packets"),
    # The board
    Calls(r"ilp::(FlightDatabase|FlightStore|ChosenStore)::",
          ["SqliteStore", "RamStore", "PostgresStore", "ValidStore", "LeasedStore", "DiskWait"], "the stores it opens"),
    Calls(r"ilp::WatchedWait::", ["Watchdog", "Clock"], "bsp/linux/watched_wait.hpp"),
    Calls(rf"\(anonymous namespace\)::(Flight::|fly\()|{LOCAL}NodeProcess::",
          ["Store", "StoreSharing", "Clock", "ImageSource", "Watchdog", "Compute", "Camera"], "bsp/linux"),
    Calls(rf"ilp::(Configuration|FlightSoftware|Boot|MemoryCopy|Node|SharedFlight|SharedCompute)::|{LOCAL}Merge::",
          ["Store", "StoreSharing", "Clock", "Nonvolatile", "DiskWait", "Watchdog"], "bsp/flight, bsp/linux"),
    # Free functions call what they are given.
    Calls(r".*\(.*ilp::MapFolder[&*]", ["MapFolder"], "the folder of the map"),
    Calls(r".*\(.*ilp::((Sqlite)?Store[&*]|StoreView<)", ["Store", "DiskWait", "Clock", "Nonvolatile"], "parameters"),
    Calls(rf".*\(.*({LOCAL}(ActiveFunction|Look)|ilp::(ServiceCall|CommandingWiring))\b", ["Store", "Clock"],
          "services and open requests"),
    Calls(r".*\(.*ilp::(VideoDevice|Compute)&", ["VideoDevice", "Compute"], "parameters"),
]

SQLITE_ARENA = rf"{LOCAL}(take|give_back|resize|size_of|round_up|initialise|shut_down)\(.*"
BUSY = r"sqlite3InvokeBusyHandler|btreeInvokeBusyHandler"
SYSTEM_CALLS = (r"_*(libc_)?(open|close|access|getcwd|[lf]?stat|f?truncate|fcntl|p?read|p?write|fchmod|posix_fallocate|"
                r"unlink|mkdir|rmdir|fchown|geteuid|mmap|munmap|mremap|readlink|ioctl)(64)?(@plt)?")
WALKERS = (r"\w*(Step|Cb|Callback|Noop|Fail|Expander|SubqueryTypeInfo|RefEnter|RefLeave|DepthIncrease|DepthDecrease)|"
           r"exprNode\w*|exprSrcCount|exprRefToSrcList|impliesNotNullRow|analyzeAggregate|propagateConstantExprRewrite|"
           r"exprColumnFlagUnion|incrAggDepth|checkConstraintExprNode|convertCompoundSelectToSubquery")

SQLITE = [
    *(Calls(rf"sqlite3Os{call}(Hint)?$",
            [rf"{LOCAL}on_{snake_case(call)}\(sqlite3_file\*.*", rf"(unix|dotlock|nolock|memjrnl){call}"],
            "sqlite3_io_methods") for call in SQLITE_IO.split()),
    Calls(r"sqlite3Os[A-Z]",
          [rf"{LOCAL}(open_file|delete_file|access_file|full_path_name|randomness|sleep_for|current_time|last_error)"
           r"\(sqlite3_vfs\*.*", UNIX_VFS], "sqlite3_vfs"),
    Calls(r"unixOpen$", [r"(posix|dotlock|nolock)IoFinderImpl", SYSTEM_CALLS], "sqlite3_vfs.pAppData, aSyscall"),
    Calls(r"robust_open", [SYSTEM_CALLS, "posixOpen"], "aSyscall"),
    Calls(r"(unix|posix|dotlock|nolock|robust|full|find|seek|verify)[A-Z_]\w*$|openDirectory|fileHasMoved|"
          r"close(PendingFds|UnixFile)|appendOnePathElement",
          [SYSTEM_CALLS, "posixOpen", "openDirectory", "unixGetpagesize"], "aSyscall: calls of the C library"),
    Calls(r"sqlite3(Malloc|Realloc|_free|Db(Malloc|Realloc|Free)|_malloc|_msize|_realloc)|measureAllocationSize|"
          r"dbRealloc", [SQLITE_ARENA], "sqlite3_mem_methods: hal/store/sqlite/sqlite_memory.cpp sets them first"),
    Calls(r"sqlite3_?[Mm]utex", [r"noopMutex\w+|pthreadMutex(Alloc|Enter|Leave|Try|Init|End|Free)"],
          "sqlite3_mutex_methods"),
    Calls(r"sqlite3P[Cc]ache", [r"pcache1[A-Z]\w*", "pagerStress"], "sqlite3_pcache_methods2, PCache.xStress"),
    Calls(r"sqlite3Wal|walCheckpoint", [BUSY, "pagerUndoCallback"], "xBusy, xUndo"),
    Calls(r"sqlite3Pager|pager", [r"getPage(Normal|MMap|Error)", "pageReinit", BUSY],
          "Pager.xGet, xReiniter, xBusyHandler"),
    Calls(r"sqlite3Btree|balance|btreeCell|checkTreePage|clearDatabasePage|computeCellSize|defragmentPage|getCellInfo|"
          r"ptrmapPut|relocatePage|indexCellCompare",
          [r"cellSizePtr\w*|btreeParseCell\w*|(sqlite3V|v)dbeRecordCompare\w*"], "MemPage.xCellSize, xParseCell"),
    Calls(r"vdbe(Sorter|Merge)", [r"vdbeSorterCompare\w*"], "VdbeSorter.xCompare"),
    Calls(r"vdbeCompareMemString", [r"binCollFunc|nocaseCollatingFunc|rtrimCollFunc"], "CollSeq.xCmp"),
    Calls(r"sqlite3InvokeBusyHandler", [r"ilp::sqlite::on_busy\(.*", "sqliteDefaultBusyCallback"],
          "sqlite3_busy_handler"),
    Calls(r"sqlite3_step|sqlite3VdbeHalt|doWalCallbacks", [r"ilp::sqlite::note_commit\(.*"], "sqlite3_wal_hook"),
    Calls(r"sqlite3_exec", ["sqlite3InitCallback"], "its callback"),
    Calls(r"sqlite3VdbeExec|sqlite3VdbeMem(AggValue|Finalize)", [r"(count|length)(Func|Step|Finalize)"],
          "count and length are the functions in statements"),
    Calls(r"walkExpr|sqlite3Walk", [WALKERS], "Walker.xExprCallback, xSelectCallback"),
    Calls(r"sqlite3Parser(Alloc|Free)|sqlite3ParserAddCleanup|sqlite3ParseObjectReset",
          [r"sqlite3Malloc|sqlite3_free|sqlite3\w+Delete|sqlite3DbFree"], "allocators and clean-up"),
    Calls(r"sqlite3VdbeMem|vdbeMem|bindText|sqlite3VdbeDeleteAuxData|sqlite3_result_\w+|callFinaliser",
          [r"sqlite3_free|sqlite3OomClear"], "destructors of values"),
    Calls(r"exprAnalyze|exprCodeBetween", [r"sqlite3ExprCodeTarget|sqlite3ExprIf(True|False)"], "xJump"),
    Calls(r"openDatabase", [r"sqlite3(Fts[135]Init|RtreeInit|DbstatRegister|JsonTableFunctions|StmtVtabInit)"],
          "sqlite3BuiltinExtensions"),
    Calls(r"sqlite3(Auth|FaultSim|BeginBenign|EndBenign|RollbackAll|ConnectionUnlocked|GetCollSeq|Close|LeaveMutex|"
          r"CreateFunc|MarkAllShadow|IsShadow|VdbePreUpdate|ThreadCreate|VdbeFreeCursor|VdbeFrame)|renderLogMsg|sqlite3_log|"
          r"invokeProfileCallback|create(Collation|FunctionApi|Module)|blobReadWrite", [],
          "hooks, authorizers and virtual tables: none is set"),
]

J2K_STEPS = (r"opj_j2k_(build_\w+|\w+_validation|setup_(en|de)coding\w*|setup_header_\w+|read_header_procedure|"
             r"decode_tiles|decode_one_tile|copy_default_tcp_and_create_tcd|init_info|create_tcd|get_end_header|"
             r"write_\w+|update_(rates|tlm)|end_encoding|destroy_header_memory)")

OPENJPEG = [
    Calls(r"opj_event_msg", [rf"{LOCAL}keep_silent\(.*"], "opj_event_mgr"),
    Calls(r"opj_stream_", [rf"{LOCAL}((read|write)_bytes|(seek|skip)_(input|output))\(.*"], "opj_stream_private"),
    Calls(r"opj_j2k_exec", [J2K_STEPS], "lists of procedures"),
    Calls(r"opj_jp2_exec", [r"opj_jp2_(read_header_procedure|\w+_validation|write_\w+|skip_jp2c|read_(jp|ftyp|jp2h))"],
          "lists of procedures"),
    Calls(r"opj_j2k_read_", [r"opj_j2k_read_[a-z]{3}|opj_j2k_read_\w+_to_\w+"], "markers, conversions"),
    Calls(r"opj_jp2_read_", [r"opj_jp2_read_[a-z]{2,4}|opj_jp2_read_jp2h"], "boxes"),
    Calls(r"opj_tls", ["opj_t1_destroy_wrapper"], "what a thread keeps"),
    Calls(r"opj_thread_pool", [r"opj_t1_clbl_decode_processor|opj_t1_cblk_encode_processor|opj_dwt_\w+_func"],
          "jobs, in the caller's thread"),
    Calls(r"opj_dwt", [r"opj_dwt_encode_and_deinterleave_\w+|opj_dwt_encode_1\w*"], "one row or column"),
    Calls(r"opj_tcd_destroy", [r"opj_tcd_code_block_\w+_deallocate"], "what a tile has"),
    Calls(r"opj_j2k_setup_mct_encoding|opj_j2k_update_rates",
          [r"opj_j2k_write_float_to_\w+|opj_j2k_get_\w+_stride"], "tables of conversions"),
    Calls(r"opj_jp2_write_jp2h", [r"opj_jp2_write_[a-z]{4}"], "boxes"),
    Calls(r"opj_setup_encoder", [r"opj_(j2k|jp2)_setup_encoder"], "opj_codec_private"),
    Calls(r"opj_setup_decoder", [r"opj_(j2k|jp2)_setup_decoder"], "opj_codec_private"),
    Calls(r"opj_(encode|decode|read_header|start_compress|end_(de)?compress|destroy_codec|(de|en)coder_\w+|set_\w+|"
          r"codec_\w+|get_\w+|write_tile)$",
          [r"opj_(j2k|jp2)_(encode|decode|read_header|start_compress|end_(de)?compress|destroy|(de|en)coder_set_\w+|"
           r"set_\w+|get_tile|write_tile)"], "opj_codec_private"),
]

# The memory manager, and what the flight gives libjpeg: errors and the source
JPEG_ERRORS = [rf"{LOCAL}(begin_source|end_of_file|refuse\w*|say_nothing|skip)\(jpeg_.*"]
JPEG = JPEG_ERRORS + [r"(alloc|request|realize|access)_(small|large|sarray|barray|virt_\w+)|free_pool|self_destruct|"
                      r"format_message|reset_error_mgr"]
MARKERS = r"get_\w+|skip_variable|save_marker|read_restart_marker|examine_\w+"
PASSES = r"start_pass\w*|finish_pass\w*|new_color_map\w*"
UPSAMPLE = r"sep_upsample|merged_\w+|\w*_upsample|\w*_convert|color_quantize\w*|\w*_quantize\w*"
OUTPUT = r"(decompress|consume)_(data|onepass|smooth_data)|post_process_\w+"

# From its interface down
LIBJPEG = [
    Calls(r"(alloc|request|realize|access|free|do)_\w*(small|large|sarray|barray|pool|virt_\w+|barray_io|sarray_io)|"
          r"jpeg_open_backing_store|out_of_memory", JPEG_ERRORS, "errors"),
    Calls(r"jinit_|add_huff_table|alloc_fs_workspace|build_ycc_rgb_table|create_colorindex|init_error_limit|"
          r"std_huff_tables|jpeg_(abort|destroy|alloc_\w+|CreateDecompress|make_\w+|calc_output_dimensions)", JPEG,
          "memory and errors"),
    Calls(r"jpeg_(consume_input|read_header|start_decompress|read_scanlines|finish_decompress|input_complete|"
          r"has_multiple_scans|start_output|finish_output)|output_pass_setup",
          JPEG + [r"consume_\w+|process_data\w*|prepare_for_output_pass|finish_output_pass|reset_input_controller"],
          "the parts of cinfo"),
    Calls(r"prepare_for_output_pass|start_(input|output)_pass", JPEG + [PASSES, "start_output_pass"], "passes"),
    Calls(r"finish_output_pass", JPEG + [PASSES], "passes"),
    Calls(r"start_pass|finish_pass|new_color_map", JPEG, "memory and errors"),
    Calls(r"reset_input_controller", JPEG + ["reset_marker_reader"], "cinfo->marker"),
    Calls(r"consume_markers", JPEG + ["read_markers", "start_input_pass"], "cinfo->marker, inputctl"),
    Calls(r"read_markers", JPEG + [MARKERS], "handlers of markers"),
    Calls(rf"{MARKERS}|first_marker|next_marker|jpeg_(fill_bit_buffer|huff_decode|resync_to_restart)|arith_decode",
          JPEG, "source and errors"),
    Calls(r"decode_mcu|process_restart", JPEG + ["read_restart_marker"], "cinfo->marker"),
    Calls(r"process_data", JPEG + [OUTPUT, UPSAMPLE], "cinfo->coef, post"),
    Calls(r"post_process", JPEG + [UPSAMPLE], "cinfo->upsample, cquantize"),
    Calls(OUTPUT, JPEG + [r"decode_mcu\w*|finish_input_pass|\w*idct\w*"], "cinfo->entropy, idct, inputctl"),
    Calls(r"sep_upsample", JPEG + [r"(fullsize|noop|int|h2v[12]|h1v2|jsimd_h\dv\d)\w*_upsample|\w*_convert"],
          "cinfo->upsample, cconvert"),
    Calls(r"merged_[12]v_upsample", JPEG + [r"(h2v[12]|jsimd_h2v[12])_merged_upsample"], "upmethod"),
    Calls(r"(h2v[12]|jsimd_h2v[12])_merged_upsample|jsimd_\w+_convert", [r"jsimd_\w+_(sse2|avx2|neon)"],
          "the processor's variant"),
]

# The C library, in static programs
C_LIBRARY = [
    Calls(r"_IO_\w+|__(overflow|uflow|underflow|printf_fp_l\w*|vfprintf_internal|printf_fphex)|buffered_vfprintf|"
          r"fflush|new_do_write|printf_positional|outstring\w*",
          [r"_IO_(new_)?(file|str|default|helper)_\w+|_IO_cleanup"], "tables of streams"),
    Calls(r"__gettimeofday|clock_gettime|time|__clock_gettime\w*", [], "the kernel's code: some words"),
    Calls(r"msort_with_tmp|_quicksort", [r"\w*([Cc]mp|[Cc]ompare)\w*"], "qsort's comparison"),
    Calls(r"__parse_one_spec\w+|mbrtowc|__wcrtomb_internal|wcsrtombs|btowc|ranged_convert|__pthread_cleanup_upto", [],
          "none is set"),
    Calls(r"____longjmp_chk|clone3|thread_start|__pthread_create|__pthread_once_slow|_pthread_cleanup_pop", [], "the beginning and end of threads"),
]

CALLS = FLIGHT + SQLITE + OPENJPEG + LIBJPEG + C_LIBRARY
