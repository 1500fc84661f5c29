# Copyright Triaxis contributors.
# SPDX-License-Identifier: Apache-2.0
#
# Non-project build of nexys4ddr_top: synthesis, placement, routing, reports, bitstream. `triaxis fpga bitstream`
# calls it, after the gate; by itself it builds whatever it is given.
#
#   vivado -mode batch -notrace -source build.tcl -tclargs FILE
#
# FILE holds a line NAME=VALUE for each option:
#   part, top     the part, the top module
#   source        a file of RTL; one line each, in order
#   include       an include folder; a line each, or none
#   xdc           the constraints
#   generic       PARAMETER=VALUE; a line each, or none
#   out           the folder of all results
#   saif          simulated activity, or none: then power is estimated
#   saif_strip    the path of the top in the activity
#
# Leaves in out/: reports, checkpoints, figures.txt (a line "name value" each), and, where all is well,
# TOP.bit. Exit status: 0 done, 1 the tool failed, 3 refused: timing, routing, critical warnings.

source [file join [file dirname [file normalize [info script]]] options.tcl]

proc stage {name} {
    puts "triaxis: stage: $name"
}

proc refuse {reason} {
    puts "triaxis: refused: $reason"
    exit 3
}

proc figure {name value} {
    global figures
    puts $figures "$name $value"
    flush $figures
    puts "triaxis: figure: $name $value"
}

# The slack of the worst path. No path at all is an error of the constraints, not a pass.
proc slack {kind} {
    set paths [get_timing_paths -delay_type $kind -max_paths 1 -nworst 1]
    set slack [if {[llength $paths]} {get_property SLACK [lindex $paths 0]}]
    # That of a path without a constraint is infinite, or empty; "inf" and "nan" are numbers to Tcl.
    if {![string is double -strict $slack] || [regexp -nocase {inf|nan} $slack]} {
        refuse "timing: no constrained path ($kind): the clock constraint is missing"
    }
    return $slack
}

# Vivado goes on after a constraint that it does not understand: a port without its pin or its pull.
proc refuse_critical_warnings {} {
    set count [get_msg_config -count -severity {CRITICAL WARNING}]
    if {$count > 0} {
        refuse "$count critical warnings: see vivado.log"
    }
}

proc synthesise {o} {
    stage synthesis
    read_verilog -sv [dict get $o source]
    read_xdc [dict get $o xdc]
    set command [list synth_design -top [dict get $o top] -part [dict get $o part] -flatten_hierarchy rebuilt]
    if {[dict get $o include] ne {}} {
        lappend command -include_dirs [dict get $o include]
    }
    foreach generic [dict get $o generic] {
        lappend command -generic $generic
    }
    {*}$command
    refuse_critical_warnings
    write_checkpoint -force [file join [dict get $o out] synthesis.dcp]
    report_utilization -file [file join [dict get $o out] utilisation_synthesis.rpt]
}

proc implement {o} {
    stage optimisation
    opt_design
    stage placement
    place_design
    phys_opt_design
    stage routing
    route_design
    # Once more where it is close: costs nothing where timing is met.
    if {[slack max] < 0} {
        stage {optimisation after routing}
        phys_opt_design
    }
    write_checkpoint -force [file join [dict get $o out] routed.dcp]
}

proc activity {o} {
    if {[dict get $o saif] eq {}} {
        return
    }
    set command [list read_saif -out_file [file join [dict get $o out] saif_unmatched.rpt]]
    if {[dict get $o saif_strip] ne {}} {
        lappend command -strip_path [dict get $o saif_strip]
    }
    {*}$command [dict get $o saif]
}

proc reports {o} {
    stage reports
    set out [dict get $o out]
    report_timing_summary -delay_type min_max -max_paths 10 -report_unconstrained \
        -file [file join $out timing.rpt]
    report_utilization -hierarchical -file [file join $out utilisation_hierarchy.rpt]
    report_utilization -file [file join $out utilisation.rpt]
    report_clock_utilization -file [file join $out clocks.rpt]
    report_io -file [file join $out io.rpt]
    report_drc -file [file join $out drc.rpt]
    report_methodology -file [file join $out methodology.rpt]
    report_route_status -file [file join $out route_status.rpt]
    activity $o
    report_power -file [file join $out power.rpt]
}

# Refuses unless everything is routed and in time, without critical warnings. The design rules write_bitstream checks itself.
proc check {o} {
    set setup [slack max]
    set hold [slack min]
    figure wns_ns $setup
    figure whs_ns $hold
    set timing [report_timing_summary -delay_type min_max -return_string -no_detailed_paths]
    set met [string match "*All user specified timing constraints are met*" $timing]
    set wrong {ROUTE_STATUS == UNROUTED || ROUTE_STATUS == PARTIAL || ROUTE_STATUS == CONFLICTS}
    set unrouted [llength [get_nets -quiet -hierarchical -filter $wrong]]
    figure unrouted_nets $unrouted
    figure critical_warnings [get_msg_config -count -severity {CRITICAL WARNING}]
    foreach {name filter} {
        dsps {REF_NAME == DSP48E1}
        ramb36 {REF_NAME == RAMB36E1}
        ramb18 {REF_NAME == RAMB18E1}
        lut_cells {REF_NAME =~ LUT*}
        ff_cells {REF_NAME =~ FD*}
    } {
        figure $name [llength [get_cells -quiet -hierarchical -filter $filter]]
    }
    if {$setup < 0} {
        refuse "timing: worst slack $setup ns: see [file join [dict get $o out] timing.rpt]"
    }
    if {$hold < 0} {
        refuse "timing: worst hold slack $hold ns: see [file join [dict get $o out] timing.rpt]"
    }
    if {!$met} {
        refuse "timing: not all constraints are met: see [file join [dict get $o out] timing.rpt]"
    }
    if {$unrouted > 0} {
        refuse "routing: $unrouted nets are not routed: see [file join [dict get $o out] route_status.rpt]"
    }
    refuse_critical_warnings
}

if {[llength $argv] != 1} {
    error "usage: -tclargs FILE, of lines NAME=VALUE"
}
set o [options [lindex $argv 0] {part top xdc out saif saif_strip} {source include generic} {part top source xdc out}]
file mkdir [dict get $o out]
file delete -force [file join [dict get $o out] "[dict get $o top].bit"]
set figures [open [file join [dict get $o out] figures.txt] w]
set_part [dict get $o part]
synthesise $o
implement $o
reports $o
check $o
stage bitstream
write_bitstream -force [file join [dict get $o out] "[dict get $o top].bit"]
close $figures
stage done
