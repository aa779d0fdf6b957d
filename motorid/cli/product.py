"""motorid product"""

from __future__ import annotations

from pathlib import Path

import click

from motorid.cli.options import example, force_option
from motorid.cli.values import Named
from motorid.errors import EXIT_DATA, EXIT_DONE


@click.group(
    "product",
    epilog=example(
        "motorid product public limits.pem --signer limits-2026 >> trusted.toml",
        "motorid product sign m17.toml --key limits.pem --signer limits-2026",
        "motorid product verify m17.toml --trusted trusted.toml",
    ),
)
def command() -> None:
    """Sign a product's limits with a named key, and see who did.

    `openssl genpkey -algorithm ed25519 -out limits.pem` makes a key.
    """


PRODUCT = click.argument("path", metavar="FILE", type=Named(dir_okay=False, path_type=Path))
SIGNER = click.option("--signer", required=True, help="The key's name, in signature and history.")
file = Named(exists=True, dir_okay=False, path_type=Path)


@command.command("sign")
@PRODUCT
@click.option("--key", required=True, type=file, help="The private key, a PEM file of Ed25519.")
@SIGNER
@force_option
def sign(path: Path, key: Path, signer: str, force: bool) -> None:
    """Sign the product file as it is now: FILE.sig, beside it."""
    from motorid.capture.whole import write_whole
    from motorid.quality import signed
    from motorid.quality.product import load_product

    product = load_product(path)  # what is no product is not signed
    made = signed.sign(product.digest, signer, key.read_bytes())
    write_whole(signed.place(path), f"{made.text}\n".encode(), force=force)
    click.echo(f"wrote {signed.place(path)}", err=True)


@command.command("public")
@click.argument("key", metavar="KEY", type=file)
@SIGNER
def public(key: Path, signer: str) -> None:
    """Print the line of a key for a file of trusted keys."""
    from motorid.quality import signed

    name = signer.replace("\\", "\\\\").replace('"', '\\"')
    click.echo(f'[keys]\n"{name}" = "{signed.public(key.read_bytes())}"')


@command.command("verify")
@PRODUCT
@click.option("--trusted", required=True, type=file, help="File of trusted keys.")
def verify(path: Path, trusted: Path) -> int:
    """Say whether a trusted key signed the product file as it is; exit code 4 where not."""
    from motorid.quality import signed
    from motorid.quality.product import load_product

    product = load_product(path)
    problem = signed.read_trusted(trusted).problem(product.signature, product.digest)
    if problem:
        click.echo(f"{path}: {problem}")
        return EXIT_DATA
    click.echo(f"{path}: signed by {signed.parse(product.signature).signer}")
    return EXIT_DONE
