# Copyright Triaxis contributors.
# SPDX-License-Identifier: Apache-2.0
#
# Options of a script, from a file with a line NAME=VALUE for each.

# The options of a file, as a dictionary. singles: may be given once; lists: a line each, or none; needed: of
# both, those that must be there.
proc options {path singles lists needed} {
    set found [dict create]
    foreach name [concat $singles $lists] {
        dict set found $name {}
    }
    set file [open $path]
    set lines [split [string trim [read $file] \n] \n]
    close $file
    foreach line $lines {
        set at [string first = $line]
        set name [string range $line 0 $at-1]
        set value [string range $line $at+1 end]
        if {![dict exists $found $name]} {
            error "$path: $line: no such option, NAME=VALUE"
        }
        if {$name in $lists} {
            dict lappend found $name $value
        } elseif {[dict get $found $name] ne {}} {
            error "$path: $line: $name is given twice"
        } else {
            dict set found $name $value
        }
    }
    foreach name $needed {
        if {[dict get $found $name] eq {}} {
            error "$path: $name is missing"
        }
    }
    return $found
}
