//! Kernel, modules and programs of the emulated machine.

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, bail};

/// Debian's kernel, unpacked.
pub struct Kernel {
    /// The kernel itself.
    pub file: PathBuf,
    root: PathBuf,
    version: String,
}

/// Downloads the current kernel package once and unpacks what is needed.
pub fn kernel(folder: &Path) -> anyhow::Result<Kernel> {
    let root = folder.join("kernel");
    if let Some(kernel) = unpacked(&root) {
        return Ok(kernel);
    }
    fs::create_dir_all(folder)?;
    let depends = Command::new("apt-cache")
        .args(["depends", "linux-image-amd64"])
        .output()
        .context("apt-cache")?;
    let depends = String::from_utf8_lossy(&depends.stdout).into_owned();
    let package = depends
        .split_whitespace()
        .find(|word| word.starts_with("linux-image-") && *word != "linux-image-amd64")
        .context("apt-cache knows no linux-image-amd64")?;
    let mut download = Command::new("apt-get");
    download.args(["download", "-q", package]);
    quietly(download.current_dir(folder))?;
    let file = fs::read_dir(folder)?
        .flatten()
        .map(|entry| entry.path())
        .find(|path| path.to_string_lossy().ends_with(".deb"))
        .context("apt-get downloaded nothing")?;
    quietly(Command::new("dpkg").arg("-x").arg(&file).arg(&root))?;
    fs::remove_file(file)?;
    unpacked(&root).context("the kernel package holds no kernel")
}

fn unpacked(root: &Path) -> Option<Kernel> {
    let modules = fs::read_dir(root.join("lib/modules")).ok()?.next()?.ok()?;
    let version = modules.file_name().to_string_lossy().into_owned();
    let file = root.join(format!("boot/vmlinuz-{version}"));
    file.exists().then(|| Kernel {
        file,
        root: root.to_owned(),
        version,
    })
}

/// Packs programs, modules and frames into an archive that the kernel unpacks into memory.
pub fn initramfs(
    folder: &Path,
    kernel: &Kernel,
    program: &Path,
    frames: &[PathBuf],
) -> anyhow::Result<PathBuf> {
    let root = folder.join("root");
    if root.exists() {
        fs::remove_dir_all(&root)?;
    }
    for name in ["bin", "modules", "usr/bin", "etc"] {
        fs::create_dir_all(root.join(name))?;
    }
    fs::copy("/bin/busybox", root.join("bin/busybox"))?;
    for applet in APPLETS {
        symlink("busybox", root.join("bin").join(applet))?;
    }
    let init = root.join("init");
    fs::write(&init, include_str!("guest.sh"))?;
    let nobody = root.join("bin/as-nobody");
    fs::write(&nobody, "#!/bin/sh\nexec su -s /bin/sh nobody -c \"$*\"\n")?;
    for script in [&init, &nobody] {
        fs::set_permissions(script, fs::Permissions::from_mode(0o755))?;
    }
    fs::write(root.join("etc/passwd"), "nobody:x:65534:65534::/:/bin/sh\n")?;
    fs::write(root.join("etc/group"), "nogroup:x:65534:\n")?;
    modules(kernel, &root.join("modules"))?;
    // Without symbols the program is a tenth of its size.
    let stripped = root.join("usr/bin/tectum");
    quietly(Command::new("strip").arg("-o").arg(&stripped).arg(program))?;
    let control = Path::new("/usr/bin/v4l2-ctl");
    fs::copy(control, root.join("usr/bin/v4l2-ctl"))?;
    for program in [&*stripped, control] {
        libraries(program, &root)?;
    }
    for file in frames {
        let name = file.file_name().context("a file without a name")?;
        fs::copy(file, root.join(name))?;
    }
    let archive = folder.join("initramfs");
    let script = "find . | cpio --quiet -o -H newc > \"$0\"";
    let mut pack = Command::new("sh");
    quietly(pack.args(["-c", script]).arg(&archive).current_dir(&root))?;
    Ok(archive)
}

/// What the script in the machine calls.
const APPLETS: &[&str] = &[
    "sh", "base64", "cat", "chmod", "chown", "cmp", "cp", "grep", "head", "ifconfig", "insmod",
    "kill", "ln", "mkdir", "mount", "nc", "poweroff", "sed", "sleep", "tail", "timeout", "tr",
    "wc",
];

/// vivid and what it needs, in the order of loading.
fn modules(kernel: &Kernel, to: &Path) -> anyhow::Result<()> {
    quietly(
        Command::new("/sbin/depmod")
            .arg("-b")
            .arg(&kernel.root)
            .arg(&kernel.version),
    )?;
    let output = Command::new("/sbin/modprobe")
        .arg("-d")
        .arg(&kernel.root)
        .args(["-S", &kernel.version, "--show-depends", "vivid"])
        .output()
        .context("modprobe")?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let mut order = String::new();
    for line in text.lines() {
        let Some(file) = line.split_whitespace().nth(1).map(Path::new) else {
            continue;
        };
        let name = file.file_name().context("a module without a name")?;
        fs::copy(file, to.join(name))?;
        order += &format!("{}\n", name.to_string_lossy());
    }
    if !order.contains("vivid") {
        bail!("this kernel has no vivid");
    }
    fs::write(to.join("order"), order)?;
    Ok(())
}

/// Copies the shared libraries of a program to where it looks for them.
fn libraries(program: &Path, root: &Path) -> anyhow::Result<()> {
    let output = Command::new("ldd").arg(program).output().context("ldd")?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    for path in text.split_whitespace().filter(|word| word.starts_with('/')) {
        let to = root.join(path.trim_start_matches('/'));
        if !to.exists() {
            fs::create_dir_all(to.parent().context("a library without a folder")?)?;
            fs::copy(path, to)?;
        }
    }
    Ok(())
}

fn quietly(command: &mut Command) -> anyhow::Result<()> {
    let status = command.stdout(Stdio::null()).status();
    if !status.is_ok_and(|status| status.success()) {
        bail!("{command:?} failed");
    }
    Ok(())
}
