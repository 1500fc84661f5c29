# Copyright Triaxis contributors.
# SPDX-License-Identifier: Apache-2.0
#
# Packages a component that `triaxis fpga ip` wrote for Vivado's catalogue, of the configuration that it is of.
#
#   vivado -mode batch -notrace -source package_ip.tcl -tclargs FOLDER/options.txt
#
# The file holds a line NAME=VALUE for each option:
#   part, vendor, library, top, version, description   of the component
#   source        a file of RTL; one line each, in order
#   include       the folder of the headers
#   generic       PARAMETER=VALUE; a line each
#   stream        STREAM ROLE=PORT, as "s_axis TDATA=s_axis_tdata_i"; a line each
#   out           the folder of the package, made anew: add it to ip_repo_paths
#
# Exit status: 0 done, 1 the tool failed.

source [file join [file dirname [file normalize [info script]]] options.tcl]

proc bus {core name kind abstraction mode ports} {
    set made [ipx::add_bus_interface $name $core]
    set_property bus_type_vlnv xilinx.com:$kind:1.0 $made
    set_property abstraction_type_vlnv xilinx.com:$abstraction:1.0 $made
    set_property interface_mode $mode $made
    dict for {role port} $ports {
        set_property physical_name $port [ipx::add_port_map $role $made]
    }
    return $made
}

proc parameter {bus name value} {
    set_property value $value [ipx::add_bus_parameter $name $bus]
}

if {[llength $argv] != 1} {
    error "usage: -tclargs FOLDER/options.txt"
}
set singles {part vendor library top version description include out}
set o [options [lindex $argv 0] $singles {source generic stream} [concat $singles {source generic stream}]]
set out [dict get $o out]
file delete -force $out
create_project -in_memory -part [dict get $o part]
read_verilog -sv [dict get $o source]
set headers [glob -directory [dict get $o include] *.svh]
add_files $headers
set_property file_type {Verilog Header} [get_files $headers]
set_property top [dict get $o top] [current_fileset]
# A list, of one folder, in whose name may be spaces.
set_property include_dirs [list [dict get $o include]] [current_fileset]
set_property generic [dict get $o generic] [current_fileset]
update_compile_order -fileset sources_1
ipx::package_project -root_dir $out -vendor [dict get $o vendor] -library [dict get $o library] \
    -taxonomy /Math_Functions -import_files
set core [ipx::current_core]
set_property name [dict get $o top] $core
set_property version [dict get $o version] $core
set_property display_name [dict get $o top] $core
set_property description [dict get $o description] $core
# Of the configuration that the ports' widths are of, and no other. An instance takes the user's value for
# that of the HDL, so both are set, and nobody can set it to another.
foreach generic [dict get $o generic] {
    lassign [split $generic =] name value
    set_property value $value [ipx::get_hdl_parameters $name -of_objects $core]
    set_property value $value [ipx::get_user_parameters $name -of_objects $core]
    set_property value_resolve_type immediate [ipx::get_user_parameters $name -of_objects $core]
}
# Those that the packager guessed.
foreach guessed [ipx::get_bus_interfaces -of_objects $core] {
    ipx::remove_bus_interface [get_property name $guessed] $core
}
set streams [dict create]
foreach line [dict get $o stream] {
    lassign $line name mapped
    lassign [split $mapped =] role port
    dict set streams $name $role $port
}
dict for {name ports} $streams {
    bus $core $name interface:axis interface:axis_rtl [expr {[string match s_* $name] ? "slave" : "master"}] $ports
}
set reset [bus $core reset signal:reset signal:reset_rtl slave {RST rst_ni}]
parameter $reset POLARITY ACTIVE_LOW
set clock [bus $core clock signal:clock signal:clock_rtl slave {CLK clk_i}]
parameter $clock ASSOCIATED_RESET rst_ni
parameter $clock ASSOCIATED_BUSIF [join [dict keys $streams] :]
if {[ipx::check_integrity $core] != 1} {
    error "the packager finds the component not whole: see its messages"
}
ipx::save_core $core
puts "triaxis: packaged: $out"
